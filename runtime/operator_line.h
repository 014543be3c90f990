// The operator's end of the links: what he orders, from one thread.
#pragma once

#include <cstdint>

#include "hal/time.h"
#include "runtime/links.h"

namespace headway::runtime {

class OperatorLine {
 public:
  explicit OperatorLine(Links& links) : links_(links) {}

  /// Goes to `goal`, in the map, in place of any other. Void where the robot is stopped before it arrives.
  /// Throws InputError while something is lost or at fault; Error where too many goals wait already.
  void go(const nav::Goal& goal);
  /// Comes to rest, whatever the frame loop does; the goal is given up.
  void stay();
  /// Somebody has looked at the fault, of the control computer or a drive: where it is gone, goals count
  /// again.
  void reset();
  /// Mission::look(). Throws Error where too many such orders wait already.
  void look(const LookOrder& order);
  /// The lease `number` was renewed at `now`; 0: nobody has control any more.
  void hold(std::uint32_t number, Time now);

  /// As of the bus loop's newest cycle.
  const SafetyReport& safety() const;

 private:
  void say() { links_.operator_word.publish(word_); }

  Links& links_;
  OperatorWord word_;  ///< the newest that was said
};

}  // namespace headway::runtime
