#include "worker.h"

#include <utility>

namespace relief::editor {

Worker::Worker(std::function<void()> idle) : idle_(std::move(idle)), thread_([this] { run(); }) {}

Worker::~Worker() {
    {
        const std::lock_guard lock(mutex_);
        ending_ = true;
        cancel();
    }
    changed_.notify_one();
    thread_.join();
}

void Worker::post(Job job) {
    {
        const std::lock_guard lock(mutex_);
        jobs_.push_back(std::move(job));
        ++posted_;
    }
    changed_.notify_one();
}

void Worker::run() {
    std::unique_lock lock(mutex_);
    for (std::uint64_t number = 0;; ++number) {
        changed_.wait(lock, [this] { return ending_ || !jobs_.empty(); });
        if (jobs_.empty()) return;
        const Job job = std::exchange(jobs_.front(), {});
        jobs_.pop_front();
        const bool last = jobs_.empty() && !ending_;
        lock.unlock();
        job([this, number] { return number >= cancelled_; });
        if (last) idle_();
        lock.lock();
    }
}

}  // namespace relief::editor
