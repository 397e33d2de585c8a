#pragma once

#include <array>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "catch.hpp"

/// What a program of this build prints without arguments; it has to end with status 0.
inline std::string printed_by(const std::string& program) {
  std::string text, command = TUTORIAL_BIN "/";
  command.append(program);
  std::FILE* pipe = popen(command.c_str(), "r");
  REQUIRE(pipe != nullptr);
  std::array<char, 4096> buffer{};
  while (std::fgets(buffer.data(), buffer.size(), pipe) != nullptr) text += buffer.data();
  CHECK(pclose(pipe) == 0);
  return text;
}

/// The number behind some words of a text; NaN where it lacks them.
inline double number_after(const std::string& text, const std::string& words) {
  INFO(text << "looked for: " << words);
  const std::size_t at = text.find(words);
  REQUIRE(at != std::string::npos);
  return std::strtod(text.c_str() + at + words.size(), nullptr);
}
