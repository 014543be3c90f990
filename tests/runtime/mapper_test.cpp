#include "runtime/mapper.h"

#include <gtest/gtest.h>

#include "tests/runtime/flat_room.h"

namespace headway::runtime {
namespace {

TEST(Mapper, VouchesForTheStartOnlyAsLongAsTheRobotStandsThere) {
  Mapper mapper(small_map(), {});
  const auto see_box_at_start = [&](const Pose2& robot) {
    const auto pose = from_above({1.7, 0}, 4.5);
    mapper.integrate(look({box(-0.2, 0.2, -0.2, 0.2, 1)}, pose), pose, robot.lifted(1), at_seconds(1));
    mapper.project();
    return mapper.floor().at(mapper.floor().grid.cell({0.01, 0.01}));
  };
  EXPECT_EQ(see_box_at_start({}), nav::Floor::kFree) << "the robot stands there, and nothing else can";
  EXPECT_EQ(see_box_at_start({0.02, 0.09, 0}), nav::Floor::kFree) << "it sways";
  EXPECT_EQ(see_box_at_start({0.8, 0, 0}), nav::Floor::kBlocked);
}

}  // namespace
}  // namespace headway::runtime
