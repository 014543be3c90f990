// How often code takes a lock that may block. A program that asks has the C library's locks wrapped.
#pragma once

#include <cstdint>

namespace headway {

/// Calls of pthread_mutex_lock, pthread_rwlock_rdlock, pthread_rwlock_wrlock and pthread_cond_wait (what
/// std::mutex and its like are made of), by this thread so far.
std::uint64_t locks_taken();

}  // namespace headway
