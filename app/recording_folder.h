// Where recordings go, and whether one can be made there.
#pragma once

#include <cstdint>
#include <filesystem>

namespace headway::app {

constexpr std::uint64_t kRoomToRecord = std::uint64_t{100} << 20;  ///< less is not begun with [bytes]

/// The one that was named; none: recordings/ with the user's state.
std::filesystem::path recording_folder(const std::filesystem::path& named);

/// Makes the folder. Throws InputError or Error where it cannot be written to, or has less than `room` left,
/// with what to do about it.
void require_room_to_record(const std::filesystem::path& folder, std::uint64_t room = kRoomToRecord);

}  // namespace headway::app
