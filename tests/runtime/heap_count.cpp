// Counts what the tests of this room take from the heap. A file of its own, so that no compiler sees through
// it.
#include <cstdlib>
#include <new>

thread_local bool g_counting = false;
thread_local int g_allocations = 0;

void* operator new(std::size_t size) {
  if (g_counting) ++g_allocations;
  if (void* p = std::malloc(size)) return p;
  throw std::bad_alloc();
}
void operator delete(void* p) noexcept { std::free(p); }
void operator delete(void* p, std::size_t) noexcept { std::free(p); }
