#pragma once

#include <random>

/// The random numbers of the tests. Seeded anew before every case (main.cpp), so that a case sees
/// the same ones alone and after others.
inline std::mt19937 generator;
constexpr unsigned random_seed = 1;
