#include "elf.h"

#include <elf.h>
#include <link.h>
#include <sys/stat.h>

#include <cstring>
#include <fstream>

namespace evenstep::internal {
namespace {

/// The header of this very program's kind, to compare with.
ElfW(Ehdr) own_header() {
  ElfW(Ehdr) header{};
  std::ifstream("/proc/self/exe", std::ios::binary).read(reinterpret_cast<char*>(&header), sizeof header);
  return header;
}

}  // namespace

std::string objection_to_library(const std::string& path) {
  struct stat about {};
  if (stat(path.c_str(), &about) != 0) return std::strerror(errno);
  if (S_ISDIR(about.st_mode)) return "is a folder";
  if (!S_ISREG(about.st_mode)) return "is no file";
  ElfW(Ehdr) header{};
  std::ifstream file(path, std::ios::binary);
  if (!file) return std::strerror(errno);
  file.read(reinterpret_cast<char*>(&header), sizeof header);
  if (file.gcount() < SELFMAG || std::memcmp(header.e_ident, ELFMAG, SELFMAG) != 0) return "is no shared object";
  if (static_cast<std::size_t>(file.gcount()) < sizeof header) return "is cut off";
  static const ElfW(Ehdr) own = own_header();
  if (header.e_ident[EI_CLASS] != own.e_ident[EI_CLASS] || header.e_machine != own.e_machine)
    return "was built for another processor";
  if (header.e_type != ET_DYN) return "is no shared object; link it with -shared";
  return {};
}

}  // namespace evenstep::internal
