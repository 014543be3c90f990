#include "runtime/real_time.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "hal/error.h"
#include "runtime/threads.h"
#include "tests/runtime/scripted_real_time.h"

namespace headway::runtime {
namespace {

using testing::HasSubstr;
using Want = RealTime::Want;

struct RealTimeSetUp : testing::Test {
  RealTime wanting(Want want, std::optional<int> processor = {}) {
    return {.want = want, .bus_processor = processor, .calls = &kernel};
  }
  /// A thread of the table that ends at once; what it was refused.
  static std::string refusal_of(ThreadId id, const RealTime& real_time, bool* begun = nullptr) {
    Thread thread(
        id,
        [&](const auto&) {
          if (begun != nullptr) *begun = true;
        },
        real_time);
    thread.stop();
    return thread.refusal();
  }
  ScriptedRealTime kernel;
};

TEST_F(RealTimeSetUp, AsksForWhatTheTableSays) {
  for (std::size_t i = 0; i < kThreads.size(); ++i) {
    kernel = {};
    const auto id = static_cast<ThreadId>(i);
    EXPECT_EQ(refusal_of(id, wanting(Want::kTry, 1)), "");
    EXPECT_EQ(kernel.priority.value_or(0), kind(id).priority) << kind(id).name;
    EXPECT_EQ(kernel.processor.has_value(), id == ThreadId::kBus) << kind(id).name;
  }
}

TEST_F(RealTimeSetUp, AsksForNothingWhenItIsOff) {
  kernel.refuse_priority = kernel.refuse_processor = kernel.refuse_memory = EPERM;
  EXPECT_EQ(refusal_of(ThreadId::kBus, wanting(Want::kOff, 1)), "");
  EXPECT_EQ(lock_memory(wanting(Want::kOff)), "");
  EXPECT_FALSE(kernel.priority);
  EXPECT_FALSE(kernel.processor);
  EXPECT_EQ(kernel.locks, 0);
}

TEST_F(RealTimeSetUp, TellsWhatIsRefusedWhyAndTheRemedyAndGoesOn) {
  kernel.refuse_priority = EPERM;
  bool begun = false;
  const std::string said = refusal_of(ThreadId::kBus, wanting(Want::kTry), &begun);
  EXPECT_TRUE(begun);
  EXPECT_THAT(said, HasSubstr("headway-bus: priority 70 refused: Operation not permitted; "));
  EXPECT_THAT(said, HasSubstr(real_time_remedy()));
  kernel.refuse_memory = ENOMEM;
  EXPECT_EQ(lock_memory(wanting(Want::kTry)),
            "memory is not locked: Cannot allocate memory; " + real_time_remedy());
}

TEST_F(RealTimeSetUp, AsksForThePriorityThoughTheProcessorIsRefused) {
  kernel.refuse_processor = EINVAL;
  EXPECT_THAT(refusal_of(ThreadId::kBus, wanting(Want::kTry, 7)), HasSubstr("processor 7 refused"));
  EXPECT_EQ(kernel.priority, kind(ThreadId::kBus).priority);
}

TEST_F(RealTimeSetUp, EndsTheProgramBeforeAnythingMovesWhereItIsEnforced) {
  bool begun = false;
  const RealTime enforced = wanting(Want::kEnforce, 7);
  EXPECT_EQ(refusal_of(ThreadId::kBus, enforced, &begun), "") << "all granted";
  EXPECT_TRUE(begun);
  const auto expect_refusal = [&](const std::string& what) {
    begun = false;
    try {
      refusal_of(ThreadId::kBus, enforced, &begun);
      ADD_FAILURE() << "began without: " << what;
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr(what));
      EXPECT_THAT(error.what(), HasSubstr("real_time: try"));
    }
    EXPECT_FALSE(begun);
  };
  kernel.refuse_priority = EPERM;
  expect_refusal(real_time_remedy());
  kernel.refuse_processor = EINVAL;
  expect_refusal("headway-bus: processor 7 refused: Invalid argument; runtime: bus_processor");
  kernel.refuse_memory = EPERM;
  EXPECT_THROW(lock_memory(enforced), InputError);
}

TEST_F(RealTimeSetUp, LocksNoMemoryUnderABound) {
  kernel.unlimited = false;
  EXPECT_THAT(lock_memory(wanting(Want::kTry)), HasSubstr("its limit is not 'unlimited'"));
  EXPECT_EQ(kernel.locks, 0) << "what is asked for later would be refused";
  EXPECT_THROW(lock_memory(wanting(Want::kEnforce)), InputError);
}

TEST_F(RealTimeSetUp, IsRefusedByTheKernelOnAProcessorThatIsNotThere) {
  EXPECT_THAT(refusal_of(ThreadId::kBus, {.want = Want::kTry, .bus_processor = 1000}),
              HasSubstr("headway-bus: processor 1000 refused: Invalid argument"));
}

TEST(RealTimeRemedy, NamesTheLinesThatDocumentsAndServiceGive) {
  EXPECT_THAT(real_time_remedy(), HasSubstr("'@headway - rtprio 70'"));
  EXPECT_THAT(real_time_remedy(), HasSubstr("'@headway - memlock unlimited'"));
  EXPECT_THAT(real_time_remedy(), HasSubstr("LimitRTPRIO=70 and LimitMEMLOCK=infinity"));
}

}  // namespace
}  // namespace headway::runtime
