#include "worker.h"

#include <future>
#include <optional>

namespace relief::editor {
namespace {

TEST(WorkerThread, DoesJobsInOrderAndAllBeforeItEnds) {
    std::vector<int> done;
    {
        Worker worker([] {});
        for (int k = 0; k < 100; ++k) worker.post([&done, k](const Wanted&) { done.push_back(k); });
    }
    ASSERT_EQ(done.size(), 100U);
    for (int k = 0; k < 100; ++k) EXPECT_EQ(done[static_cast<std::size_t>(k)], k);
}

TEST(WorkerThread, CancelReachesWhatWasPostedBeforeIt) {
    std::promise<void> started;
    std::promise<void> cancelled;
    std::array<bool, 4> wanted{};
    {
        Worker worker([] {});
        worker.post([&](const Wanted& still) {
            wanted[0] = still();
            started.set_value();
            cancelled.get_future().wait();
            wanted[1] = still();
        });
        worker.post([&](const Wanted& still) { wanted[2] = still(); });
        started.get_future().wait();
        worker.cancel();
        std::promise<void> after;
        worker.post([&](const Wanted& still) {
            wanted[3] = still();
            after.set_value();
        });
        cancelled.set_value();
        after.get_future().wait();
    }
    EXPECT_EQ(wanted, (std::array<bool, 4>{true, false, false, true}));
}

TEST(WorkerThread, IsIdleAfterTheLastJob) {
    std::atomic<int> jobs{0};
    std::promise<int> idle;
    std::promise<void> go;
    Worker worker([&] { idle.set_value(jobs); });
    worker.post([&](const Wanted&) {
        go.get_future().wait();
        ++jobs;
    });
    worker.post([&](const Wanted&) { ++jobs; });
    go.set_value();
    EXPECT_EQ(idle.get_future().get(), 2);
}

}  // namespace
}  // namespace relief::editor
