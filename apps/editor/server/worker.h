#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>

#include "conversation.h"

namespace relief::editor {

/// A thread that does jobs one after another.
class Worker {
  public:
    /// A job may ask whether it is still wanted.
    using Job = std::function<void(const Wanted&)>;

    /// idle: called in the thread after a job that no other follows.
    explicit Worker(std::function<void()> idle);
    Worker(const Worker&) = delete;
    Worker& operator=(const Worker&) = delete;
    /// Waits for all jobs, none of which is wanted any more.
    ~Worker();

    void post(Job job);
    /// Jobs that were posted so far are no longer wanted. They run nevertheless.
    void cancel() { cancelled_ = posted_.load(); }

  private:
    void run();

    std::function<void()> idle_;
    std::mutex mutex_;
    std::condition_variable changed_;
    std::deque<Job> jobs_;                     ///< guarded by mutex_
    bool ending_ = false;                      ///< the same
    std::atomic<std::uint64_t> posted_{0};     ///< jobs, ever
    std::atomic<std::uint64_t> cancelled_{0};  ///< the first so many of them are not wanted
    std::thread thread_;
};

}  // namespace relief::editor
