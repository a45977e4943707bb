// A process solver that does what its first argument says. "good" is F = -200 x. It was written from
// docs/parts/process-protocol.md.
#include <unistd.h>

#include <cmath>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <string_view>

namespace {

std::string_view fault;
bool is(std::string_view name) { return fault == name; }

[[noreturn]] void sleep_forever() {
  for (;;) pause();
}

bool read_all(char* bytes, std::size_t size) { return std::fread(bytes, 1, size, stdin) == size; }
void write_all(const char* bytes, std::size_t size) {
  if (std::fwrite(bytes, 1, size, stdout) != size || std::fflush(stdout) != 0) std::exit(9);
}

/// How many tools there are.
std::size_t greet() {
  char line[65536];
  if (is("exits")) std::fprintf(stderr, "no such mesh\n"), std::exit(3);
  if (is("mute")) sleep_forever();
  if (std::fgets(line, sizeof line, stdin) == nullptr) std::exit(0);
  if (is("prints")) std::printf("Loading mesh ...\n");
  if (is("long_line")) std::printf("%s", std::string(5000, 'x').c_str());
  if (is("other_protocol")) std::printf("{\"protocol\": 2}\n");
  if (is("other_has")) std::printf("{\"protocol\": 1, \"has\": [\"mesh\"]}\n");
  if (is("half_line")) std::printf("{\"proto"), std::fflush(stdout), std::exit(0);
  if (is("where")) {
    char folder[4096];
    std::fprintf(stderr, "in %s, asked %s", getcwd(folder, sizeof folder), line);
  }
  if (is("rich"))
    std::printf("{\"protocol\": 1, \"has\": [\"contacts\", \"energy\"]}\n");
  else
    std::printf("{\"protocol\": 1, \"has\": [\"state_digest\", \"reset\"]}\n");
  std::fflush(stdout);
  return std::strstr(line, "\"tools\":2") == nullptr ? 1 : 2;
}

struct Answer {
  std::uint32_t kind, status;
  std::uint64_t n, digest;
  double energy_J, force_N[6];
};

/// The fault, at step 5.
void do_harm(Answer& answer, std::size_t size) {
  const char* const bytes = reinterpret_cast<const char*>(&answer);
  if (is("hangs")) sleep_forever();
  if (is("exits_at_5")) std::fprintf(stderr, "Traceback\nZeroDivisionError: division by zero\n"), std::exit(7);
  if (is("aborts_at_5")) std::raise(SIGABRT);
  if (is("closes_output")) close(1), sleep_forever();
  if (is("short")) write_all(bytes, size / 2), std::exit(0);
  if (is("short_hangs")) write_all(bytes, size / 2), sleep_forever();
  if (is("rubbish")) write_all(std::string(size, 'A').c_str(), size);
  if (is("more")) {
    std::string both(bytes, size);
    both += "debug";
    write_all(both.c_str(), both.size());
  }
  if (is("nan")) answer.force_N[0] = std::nan("");
  if (is("status_1")) answer.status = 1;
  if (is("status_2")) answer.status = 2;
  if (is("status")) std::fprintf(stderr, "the mesh is torn\n"), answer.status = 3;
}

/// One contact, at (1, 0, 0), which is all that is not 0 in it.
void write_contact() {
  char contact[136] = {};
  const double one = 1;
  std::memcpy(contact + 8, &one, sizeof one);
  write_all(contact, sizeof contact);
}

}  // namespace

int main(int argc, char** argv) {
  fault = argc > 1 ? argv[1] : "good";
  if (is("has_child") && fork() == 0) sleep_forever();
  if (is("stays")) std::signal(SIGTERM, SIG_IGN);
  const std::size_t tools = greet();
  char request[24 + 48];
  const std::size_t size = 32 + 24 * tools;
  std::uint64_t digest = 0;
  while (read_all(request, 24 + 24 * tools)) {
    Answer answer{};
    double x[6];
    std::memcpy(&answer.kind, request, 4);
    std::memcpy(&answer.n, request + 8, 8);
    std::memcpy(x, request + 24, 24 * tools);
    digest = answer.kind == 2 ? 0 : digest * 31 + answer.n;
    answer.digest = digest;
    for (std::size_t i = 0; i < 3 * tools; ++i) answer.force_N[i] = -200 * x[i];
    if (is("chatty")) std::fprintf(stderr, "%s\n", std::string(100'000, 'c').c_str());
    if (is("rich")) answer.energy_J = 0.5;
    if (answer.n == 4 && (is("reads_no_more") || is("quits"))) close(0);
    if (answer.n == 5) do_harm(answer, size);
    if (!(answer.n == 5 && (is("rubbish") || is("more")))) write_all(reinterpret_cast<const char*>(&answer), size);
    if (is("rich")) write_contact();
  }
  if (is("stays") || is("reads_no_more")) sleep_forever();
  return 0;
}
