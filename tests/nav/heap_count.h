// How often this test program has taken memory from the heap with `new`.
#pragma once

#include <cstdint>

namespace headway {
std::uint64_t heap_allocations();
}
