// faults NAME : commits one fault that a sanitizer must report. Values are volatile, so that no fault is optimized away.
#include <climits>
#include <cstdio>
#include <string_view>
#include <thread>
#include <vector>

namespace {

void leak() {
  int* volatile kept = new int[250]{1, 2, 3};
  kept = nullptr;
  static_cast<void>(kept);
}

void overflow() {
  volatile std::size_t count = 4;
  int* const four = new int[count]{};
  volatile int read = four[count];
  static_cast<void>(read);
  delete[] four;
}

int* volatile escaped;

[[gnu::noinline]] void let_local_escape() {
  int local = 1;
  escaped = &local;
}

void use_after_return() {
  let_local_escape();
  *escaped = 2;
}

void signed_overflow() {
  volatile int most = INT_MAX;
  most = most + 1;
}

void cast_overflow() {
  volatile double large = 1e30;
  volatile int cut = static_cast<int>(large);
  static_cast<void>(cut);
}

void vector_index() {
  std::vector<int> reserved;
  reserved.reserve(8);  // this memory may be touched, but the elements do not exist
  volatile std::size_t first = 0;
  volatile int read = reserved[first];
  static_cast<void>(read);
}

void race() {
  int shared = 0;
  const auto write = [&] {
    for (int i = 0; i < 100'000; ++i) *const_cast<volatile int*>(&shared) = i;
  };
  std::thread other(write);
  write();
  other.join();
}

struct Fault {
  std::string_view name;
  void (*commit)();
};
constexpr Fault kFaults[] = {{"leak", leak},
                             {"overflow", overflow},
                             {"use-after-return", use_after_return},
                             {"signed-overflow", signed_overflow},
                             {"cast-overflow", cast_overflow},
                             {"vector-index", vector_index},
                             {"race", race}};

}  // namespace

int main(int count, char** arguments) {
  for (const Fault& fault : kFaults) {
    if (count != 2 || fault.name != arguments[1]) continue;
    fault.commit();
    std::puts("nothing stopped it");
    return 0;
  }
  return 2;
}
