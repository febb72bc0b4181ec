#pragma once
// Leaves, elasticity matrices and densities of a tree in one call, from a file when they were computed before.
//
//     CoarseMaterials m = coarse_materials(tree, function, {}, {.directory = default_cache_directory()}, progress);
//
// A cache file is named after a hash of the root mesh, the depth, the stiffness function, the estimation settings and
// the format version. It is written to a temporary file of its own, flushed to disk and renamed, so that another
// process sees all of it or nothing, and two that compute the same at once both succeed. A file that is truncated,
// damaged or of another version is reported once and replaced; a cache that cannot be written is reported and does
// without.

#include "engine/base/progress.hpp"
#include "engine/mechanics/elasticity.hpp"

#include <filesystem>
#include <functional>
#include <string>

namespace tetfront {

struct CoarseMaterials {
    ElasticityMatrices matrices;
    PerTet<double> density;  // [T] [kg/m^3]
    bool from_cache = false;
};

struct CacheSettings {
    std::filesystem::path directory;  // empty: no cache
    std::function<void(const std::string&)> warn =
        {};  // one line for people: a bad cache file, a directory without write access
};

/// $XDG_CACHE_HOME/tetfront, or ~/.cache/tetfront; empty when neither variable is set.
std::filesystem::path default_cache_directory();

/// integrate_leaves, estimate_elasticity and coarse_density, or what they returned before. Throws what they throw.
CoarseMaterials coarse_materials(const TetTree& tree, const StiffnessFunction& function,
                                 const EstimationSettings& settings, const CacheSettings& cache,
                                 const Progress& progress = {});

/// The file that coarse_materials uses.
std::filesystem::path cache_file(const TetTree& tree, const StiffnessFunction& function,
                                 const EstimationSettings& settings, const std::filesystem::path& directory);

}  // namespace tetfront
