// A reader of recordings that is not ours: mcap_peer/peer.js (npm's @mcap/core) on a file.
#pragma once

#include <array>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>

#include <nlohmann/json.hpp>
#include <sys/wait.h>

#include "tests/source_dir/source_dir.h"

namespace headway::testing {

/// What the peer says of the file; nothing where node or its packages are not installed. {"error": ...} for a
/// file that it does not take.
inline std::optional<nlohmann::json> mcap_peer(const std::filesystem::path& file) {
  const std::string script = (source_dir() / "tests/runtime/mcap_peer/peer.js").string();
  const std::string command = "node '" + script + "' '" + file.string() + "' 2>/dev/null";
  FILE* pipe = popen(command.c_str(), "r");
  std::string said;
  std::array<char, 4096> part;
  while (const std::size_t size = std::fread(part.data(), 1, part.size(), pipe))
    said.append(part.data(), size);
  const int status = pclose(pipe);
  constexpr int kNotInstalled = 77, kNoNode = 127;
  const int code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  if (code == kNotInstalled || code == kNoNode) return std::nullopt;
  return nlohmann::json::parse(said);
}

}  // namespace headway::testing
