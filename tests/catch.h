#pragma once
/// Catch2 for all tests, whether the installed one is version 2 (Debian 12) or 3 (Debian 13, Ubuntu 24.04): the tests use
/// what both have, under the names of version 2.

#if __has_include(<catch2/catch_test_macros.hpp>)
#include <catch2/catch_approx.hpp>
#include <catch2/catch_template_test_macros.hpp>
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>
#include <catch2/generators/catch_generators_range.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#ifdef CATCH_CONFIG_RUNNER  // version 2 wants this of the one source that has the main function
#include <catch2/catch_session.hpp>
#endif

namespace Catch {
using Matchers::EndsWith, Matchers::Matches, Matchers::StartsWith;
/// Version 3 has given this name to a matcher of ranges.
inline Matchers::StringContainsMatcher Contains(const std::string& text) { return Matchers::ContainsSubstring(text); }
}  // namespace Catch
using Catch::Approx;
#else
#include <catch2/catch.hpp>
#endif
