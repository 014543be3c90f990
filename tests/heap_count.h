// How often code takes memory from the heap. A program that asks has its operators new and delete replaced.
#pragma once

#include <cstdint>

namespace headway {

/// Calls of `new`, of any kind, by this thread so far.
std::uint64_t heap_allocations();

}  // namespace headway
