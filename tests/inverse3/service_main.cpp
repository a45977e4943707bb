// The service as a separate process. It prints its address and serves until it is killed or its input ends.
#include <cstdio>
#include <string>

#include "service.h"

int main() {
  const evenstep::test::Service service;
  std::printf("%s\n", service.address().c_str());
  std::fflush(stdout);
  while (std::getchar() != EOF) {
  }
}
