#pragma once

#include "instruments/pictures/pictures.hpp"
#include "report.hpp"

namespace peers {

/// Error against processor time: of each engine what its best settings reach, and itself as it
/// comes.
pictures::Picture slider_crank_picture(const Report& report);

/// What each engine is for: its run as it comes, beside the words of its makers.
pictures::Picture purpose_picture(const Report& report);

/// Processor time of a step against the number of links.
pictures::Picture chain_picture(const Report& report);

}  // namespace peers
