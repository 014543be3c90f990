#include "app/can_transport.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/other_master.h"

namespace headway::app {
namespace {

using testing::UnorderedElementsAre;

TEST(CanTransport, LetsTheLoopsHearDrivesAndControlComputerAndNotTheirOwnKind) {
  EXPECT_THAT(identifiers_of_the_loops(),
              UnorderedElementsAre(0x091, 0x092, 0x130, 0x131, 0x132, 0x140, 0x191, 0x192, 0x291, 0x292,
                                   0x591, 0x592, 0x711, 0x712));
  for (const std::uint32_t id : identifiers_of_the_loops())
    EXPECT_FALSE(word_of_a_master({.id = id, .dlc = 0, .data = {}, .stamp = {}})) << id;
}

}  // namespace
}  // namespace headway::app
