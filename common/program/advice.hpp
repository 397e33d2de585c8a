#pragma once

#include <optional>
#include <string>

#include "program/chapter.hpp"

namespace program {

/// Nothing where the feedback is stable at the run's step; else what is wrong, in one line.
std::optional<std::string> fault_of_gains(const RunOptions& run);

/// What to try after a run that could not go on.
std::string advice(const Chapter& chapter, const RunOptions& run, measure::Trouble trouble);

}  // namespace program
