// Eyes of a camera that never shows anything: the frame loop only looks for frames.
#pragma once

#include <optional>
#include <string>

#include "runtime/eyes.h"

namespace headway::test {

class ShutEyes final : public runtime::Eyes {
 public:
  std::optional<runtime::FrameStamp> take() override { return std::nullopt; }
  const vision::RangeView& see() override { return view_; }
  Eigen::Isometry3d left_from_view() const override { return Eigen::Isometry3d::Identity(); }
  const std::string& fault() const override { return fault_; }

 private:
  vision::RangeView view_;
  std::string fault_;
};

}  // namespace headway::test
