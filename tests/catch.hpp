#pragma once

// Catch2, version 2 (Debian 12) or 3 (later systems), by the names of version 3.
#if __has_include(<catch2/catch_all.hpp>)
#include <catch2/catch_all.hpp>
using Catch::Approx;
using Catch::Matchers::ContainsSubstring;
constexpr auto no_such_case = Catch::WarnAbout::UnmatchedTestSpec;
#else
#include <catch2/catch.hpp>
inline auto ContainsSubstring(const std::string& text) { return Catch::Contains(text); }
#ifdef CATCH_CONFIG_RUNNER
namespace Catch {
using EventListenerBase = TestEventListenerBase;
}
constexpr auto no_such_case = Catch::WarnAbout::NoTests;
#endif
#endif
