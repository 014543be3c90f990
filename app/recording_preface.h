// What each file of a recording begins with: the robot file, its rig, the map known from before, the cameras'
// calibration, and how the loops were set up.
#pragma once

#include <map>
#include <optional>
#include <string>

#include "app/loop_setup.h"
#include "nav/cold_map_file.h"
#include "runtime/preface.h"
#include "runtime/recording/mcap_reader.h"

namespace headway::app {

// Names of attachments.
inline constexpr const char* kRobotFile = "robot.yaml";
inline constexpr const char* kRigFolder = "rig/";  ///< of its files
inline constexpr const char* kKnownMap = "known.hmap";

/// `robot` as it was read. Throws InputError where its files can no longer be read.
runtime::Preface recording_preface(const Robot& robot, const LoopSetup& setup, const std::string& command);
/// The map that the robot is set up in; read back from what is kept, so that a replay has the very same.
nav::SavedMap keep_known_map(const nav::SavedMap& known, runtime::Preface& preface);

/// What a recording was made with.
struct RecordedSetup {
  Robot robot;  ///< as `with` makes it of the files
  LoopSetup setup;
  std::optional<nav::SavedMap> known;
};

/// Throws InputError where the recording does not hold it, or it is damaged.
RecordedSetup recorded_setup(recording::McapReader& recording);

}  // namespace headway::app
