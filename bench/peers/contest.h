#pragma once

#include <time.h>

#include <iterator>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

/// What all comparisons with other libraries share.
namespace relief::peers {

/// What is measured beside others of its kind.
class Contestant {
  public:
    Contestant() = default;
    Contestant(const Contestant&) = delete;
    Contestant& operator=(const Contestant&) = delete;
    virtual ~Contestant() = default;

    [[nodiscard]] virtual std::string name() const = 0;
};

template <class Kind>
using Contestants = std::vector<std::unique_ptr<Kind>>;

template <class Kind>
void append(Contestants<Kind>& all, Contestants<Kind> some) {
    all.insert(all.end(), std::make_move_iterator(some.begin()),
               std::make_move_iterator(some.end()));
}

/// What a clock says, in seconds.
[[nodiscard]] inline double seconds_of(clockid_t clock) {
    timespec time{};
    clock_gettime(clock, &time);
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}
[[nodiscard]] inline double thread_seconds() {
    return seconds_of(CLOCK_THREAD_CPUTIME_ID);
}

/// The name of a file without folders and extension.
[[nodiscard]] inline std::string stem(std::string_view path) {
    path.remove_prefix(path.find_last_of('/') + 1);
    return std::string(path.substr(0, path.find_last_of('.')));
}

}  // namespace relief::peers
