#include "runtime/second_look.h"

namespace headway::runtime {

namespace {

constexpr double kSomewhere = 0.1;  // the robot got on by so much [m]

}  // namespace

void SecondLook::forget() {
  on_ = false;
  times_ = 0;
}

void SecondLook::follow(const Mapper& mapper) {
  doubted_.see(mapper.floor());
  if (on_) doubted_.hope(mapper.floor(), mapper.passing(), hoped_);
}

bool SecondLook::begin(const Mapper& mapper, const Eigen::Vector2d& robot, Time closed) {
  if (times_ >= most_) return false;
  ++times_;
  on_ = true;
  from_ = robot;
  doubted_.doubt(mapper.floor(), mapper.passing(), closed);
  doubted_.hope(mapper.floor(), mapper.passing(), hoped_);
  return true;
}

void SecondLook::end(const Mapper& mapper, const Eigen::Vector2d& robot) {
  on_ = false;
  doubted_.believe(mapper.floor(), mapper.passing());
  if ((robot - from_).norm() < kSomewhere) times_ = most_;
}

}  // namespace headway::runtime
