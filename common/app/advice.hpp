#pragma once

#include <optional>
#include <string>

#include "app/chapter.hpp"

namespace app {

/// Nothing where the feedback is stable at the run's step; else what is wrong, in one line.
std::optional<std::string> fault_of_gains(const measure::RunOptions& run);

/// What to try after a run that could not go on or is far from right, "try a smaller --step"; or,
/// where a term is left out, that this is why.
std::string advice(const Chapter& chapter, const measure::RunOptions& run,
                   mechanics::Trouble trouble);

}  // namespace app
