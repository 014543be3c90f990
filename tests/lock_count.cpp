// A file of its own, so that no compiler sees through it.
#include "tests/lock_count.h"

#include <dlfcn.h>
#include <pthread.h>

namespace {

thread_local std::uint64_t taken = 0;

/// The C library's own, which this program's stands before.
template <class Call>
Call* real(const char* name) {
  return reinterpret_cast<Call*>(dlsym(RTLD_NEXT, name));
}

}  // namespace

extern "C" {

int pthread_mutex_lock(pthread_mutex_t* mutex) {
  static const auto call = real<int(pthread_mutex_t*)>("pthread_mutex_lock");
  ++taken;
  return call(mutex);
}
int pthread_rwlock_rdlock(pthread_rwlock_t* lock) {
  static const auto call = real<int(pthread_rwlock_t*)>("pthread_rwlock_rdlock");
  ++taken;
  return call(lock);
}
int pthread_rwlock_wrlock(pthread_rwlock_t* lock) {
  static const auto call = real<int(pthread_rwlock_t*)>("pthread_rwlock_wrlock");
  ++taken;
  return call(lock);
}
int pthread_cond_wait(pthread_cond_t* condition, pthread_mutex_t* mutex) {
  static const auto call = real<int(pthread_cond_t*, pthread_mutex_t*)>("pthread_cond_wait");
  ++taken;
  return call(condition, mutex);
}

}  // extern "C"

namespace headway {

std::uint64_t locks_taken() { return taken; }

}  // namespace headway
