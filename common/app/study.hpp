#pragma once

#include <memory>
#include <vector>

// What the study of a chapter is made of, by its names alone: its main, which only hands over to
// it, compiles none of that.

namespace mechanics {
struct Columns;
struct Method;
struct Row;
}  // namespace mechanics

namespace measure {
struct RunOptions;
struct Stability;
}  // namespace measure

namespace pictures {
struct Picture;
class Stage;
}  // namespace pictures
