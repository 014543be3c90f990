// The program as a user calls it, with what it says kept.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "app/commands.h"

namespace headway::app::test {

struct Outcome {
  int code = 0;
  std::string said, error;  ///< on stdout and on stderr
};

inline Outcome run_headway(const std::vector<std::string>& arguments) {
  std::vector<const char*> argv{"headway"};
  for (const std::string& a : arguments) argv.push_back(a.c_str());
  testing::internal::CaptureStderr();
  testing::internal::CaptureStdout();
  Outcome outcome;
  outcome.code = run_program(static_cast<int>(argv.size()), argv.data());
  outcome.said = testing::internal::GetCapturedStdout();
  outcome.error = testing::internal::GetCapturedStderr();
  return outcome;
}

/// Bad input in one line on stderr, with all of these in it.
inline testing::AssertionResult says(const Outcome& outcome, const std::vector<std::string>& parts) {
  if (outcome.code != kBadInput) return testing::AssertionFailure() << "exit code " << outcome.code;
  if (std::count(outcome.error.begin(), outcome.error.end(), '\n') != 1)
    return testing::AssertionFailure() << "not one line: " << outcome.error;
  for (const std::string& part : parts)
    if (outcome.error.find(part) == std::string::npos) return testing::AssertionFailure() << outcome.error;
  return testing::AssertionSuccess();
}

}  // namespace headway::app::test
