#pragma once
// From what a scene says about its material to the stiffness function and the settings of the estimation.
//
//     StiffnessFunction f = make_stiffness(scene, roots);
//     CoarseMaterials m = coarse_materials(tree, f, estimation_settings(scene.estimation), cache, progress);

#include "engine/material/stiffness.hpp"
#include "engine/material/voxel_image.hpp"
#include "engine/mechanics/elasticity.hpp"
#include "engine/mesh/tet_mesh.hpp"
#include "engine/scene/scene.hpp"

namespace tetfront {

/// Reads the voxel images that the scene names. Throws InputError that names the scene's JSON pointer, or the image.
StiffnessFunction make_stiffness(const Scene& scene, const TetMesh& roots);

/// The image with metres for its units.
VoxelImage scaled_image(const std::filesystem::path& file, double scale);

EstimationSettings estimation_settings(const EstimationSpec& spec);

}  // namespace tetfront
