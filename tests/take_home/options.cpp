#include "app/options.hpp"

static_assert(this_is_somebody_elses);
