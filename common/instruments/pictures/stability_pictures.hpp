#pragma once

#include <string>
#include <vector>

#include "instruments/measure/stability_map.hpp"
#include "instruments/pictures/pictures.hpp"

namespace pictures {

/// The measured maps of a scene beside theory, and the energy errors of its long runs.
Picture map_picture(const std::string& scene, const std::vector<measure::Map>& maps,
                    const std::string& remark);
Picture long_run_picture(const std::string& scene, const std::vector<measure::LongCurve>& curves,
                         double step);

}  // namespace pictures
