#pragma once
// The smooth boundary of some labels of a voxel image: organs straight from a segmentation.
//
//     SurfaceMesh liver = voxel_surface(read_voxel_image("liver.inr.gz"), {}, 0.004);
//
// The field whose level one half is taken is the share of wanted voxels in a cube of twice the surface's cell around
// each sample, so that the steps of the voxels are smoothed away and details below a cell with them.

#include "engine/material/voxel_image.hpp"
#include "engine/mesh/tet_mesh.hpp"

#include <set>

namespace tetfront {

/// labels: which voxels are inside; empty: all whose value is not 0. cell: edge of the lattice on which the surface is
/// found [m]. Throws InputError when no voxel is inside, the surface vanishes at this cell, or it is too fine.
SurfaceMesh voxel_surface(const VoxelImage& image, const std::set<long long>& labels, double cell);

/// Longest side of the box around the voxels that are inside [m]. Throws InputError when there is none.
double voxel_extent(const VoxelImage& image, const std::set<long long>& labels);

}  // namespace tetfront
