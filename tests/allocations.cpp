#include "allocations.hpp"

#include <atomic>
#include <cstddef>

#if defined(__SANITIZE_ADDRESS__) || !defined(__GLIBC__)
#define TESTS_COUNT_ALLOCATIONS 0
#else
#define TESTS_COUNT_ALLOCATIONS 1
#endif
#if defined(__has_feature)
#if __has_feature(address_sanitizer)
#undef TESTS_COUNT_ALLOCATIONS
#define TESTS_COUNT_ALLOCATIONS 0
#endif
#endif

namespace {
std::atomic<long> count = 0;
}

long allocations() { return count; }

#if TESTS_COUNT_ALLOCATIONS
// A program's own malloc takes the place of the C library's; glibc keeps its own under these names.
extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);

void* malloc(std::size_t size) {
  ++count;
  return __libc_malloc(size);
}
void* calloc(std::size_t number, std::size_t size) {
  ++count;
  return __libc_calloc(number, size);
}
void* realloc(void* old, std::size_t size) {
  ++count;
  return __libc_realloc(old, size);
}
}
#endif
