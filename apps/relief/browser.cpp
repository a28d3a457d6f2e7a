#include "browser.h"

#include <fcntl.h>
#include <spawn.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <sstream>

namespace relief::cli {

namespace {

/// What the command has to say does not mix with what we have.
class Silence {
  public:
    Silence() {
        posix_spawn_file_actions_init(&actions_);
        posix_spawn_file_actions_addopen(&actions_, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
        posix_spawn_file_actions_addopen(&actions_, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
        posix_spawn_file_actions_addopen(&actions_, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
    }
    Silence(const Silence&) = delete;
    Silence& operator=(const Silence&) = delete;
    ~Silence() { posix_spawn_file_actions_destroy(&actions_); }
    [[nodiscard]] const posix_spawn_file_actions_t* get() const { return &actions_; }

  private:
    posix_spawn_file_actions_t actions_{};
};

bool start(std::string command, std::string url) {
    const Silence silence;
    const std::array<char*, 3> words = {command.data(), url.data(), nullptr};
    pid_t process = 0;
    return ::posix_spawnp(&process, command.c_str(), silence.get(), nullptr, words.data(),
                          environ) == 0;
}

}  // namespace

bool open_browser(const std::string& url) {
    const char* wanted = std::getenv("BROWSER");
    std::istringstream names(wanted ? wanted : "");
    for (std::string name; std::getline(names, name, ':');)
        if (!name.empty() && start(name, url)) return true;
    return start("xdg-open", url);
}

}  // namespace relief::cli
