#pragma once
/// The parts that a build of evenstep may lack (docs/begin/install.md, "Options"). Whatever refuses something for lack of a
/// part takes its message from here, so that every message says what is missing and how to get it.

#include <array>
#include <string>
#include <string_view>

namespace evenstep {

struct BuildOption {
  std::string_view name;    ///< of CMake
  std::string_view brings;  ///< what an evenstep with it has
  std::string_view needs;   ///< packages of scripts/packages.txt
};

namespace build_option {
inline constexpr BuildOption kOpenCl{"EVENSTEP_OPENCL", "OpenCL", "opencl-c-headers"};
inline constexpr BuildOption kHidapi{"EVENSTEP_HIDAPI", "hidapi", "libhidapi-dev"};
inline constexpr BuildOption kInverse3{"EVENSTEP_INVERSE3", "the connection to a Haply Inverse3", "libboost-dev"};
inline constexpr BuildOption kDraw{"EVENSTEP_DRAW", "OpenGL", "libegl-dev, libgles-dev and zlib1g-dev"};
inline constexpr BuildOption kProfiles{"EVENSTEP_PROFILES", "SQLite and zlib", "libsqlite3-dev and zlib1g-dev"};
inline constexpr BuildOption kScope{"EVENSTEP_SCOPE", "the page of --scope", "libboost-dev"};
}  // namespace build_option

inline constexpr std::array kBuildOptions{build_option::kOpenCl, build_option::kHidapi,   build_option::kInverse3,
                                          build_option::kDraw,   build_option::kProfiles, build_option::kScope};

/// "this evenstep is built without OpenCL"
std::string built_without(const BuildOption& option);
/// "build it with -D EVENSTEP_OPENCL=ON, which needs opencl-c-headers"; after `otherwise`, another remedy, if there is one.
std::string remedy_without(const BuildOption& option, std::string_view otherwise = {});
/// Both, in one sentence.
std::string refusal_without(const BuildOption& option, std::string_view otherwise = {});

}  // namespace evenstep
