#pragma once

#include "program/pictures.hpp"
#include "report.hpp"

namespace peers {

/// Error against processor time: of each engine what its best settings reach, and itself as it
/// comes.
program::Picture slider_crank_picture(const Report& report);

/// Processor time of a step against the number of links.
program::Picture chain_picture(const Report& report);

}  // namespace peers
