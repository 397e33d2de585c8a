#pragma once

#include <string>

namespace ground {

/// What leaving the ground out saves, as a table.
std::string left_out_table();

}  // namespace ground
