// SPDX-License-Identifier: MIT
#include "allocations.h"

#include <atomic>
#include <cstdlib>
#include <new>

namespace gyrobudget::tests {
namespace {
std::atomic<std::size_t> count{0};
}  // namespace

std::size_t allocations() { return count; }

/// Counts a call of operator new.
void count_allocation() { ++count; }

}  // namespace gyrobudget::tests

void* operator new(std::size_t size) {
  gyrobudget::tests::count_allocation();
  if (void* memory = std::malloc(size == 0 ? 1 : size)) return memory;
  throw std::bad_alloc();
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
