#pragma once

#include <optional>
#include <string>

#include "program/chapter.hpp"

namespace program {

/// The step up to which the feedback is stable, 0 where none is; nothing where it is stable as it
/// is.
std::optional<double> limit_of_feedback(const RunOptions& run);

/// What to try after a run that could not go on.
std::string advice(const Chapter& chapter, const RunOptions& run);

}  // namespace program
