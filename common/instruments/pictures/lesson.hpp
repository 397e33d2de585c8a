#pragma once

#include <fmt/format.h>

#include <Eigen/Core>

#include "instruments/draw/canvas.hpp"
#include "instruments/draw/page.hpp"
#include "instruments/measure/run_options.hpp"
#include "instruments/pictures/pictures.hpp"
#include "instruments/pictures/stage.hpp"

/// What the pictures of every lesson are made of.
namespace pictures::lesson {

using draw::Canvas;
using draw::Point;
using Eigen::Vector2d;
using measure::RunOptions;
using mechanics::Method;
using mechanics::Stabilization;
using pictures::Picture;

inline Point point(const Vector2d& x) { return {x.x(), x.y()}; }

}  // namespace pictures::lesson
