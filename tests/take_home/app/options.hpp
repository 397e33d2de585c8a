#pragma once

// The tutorial has a file of this name too.
constexpr bool this_is_somebody_elses = true;
