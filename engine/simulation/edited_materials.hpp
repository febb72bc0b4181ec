#pragma once
// What a model is made of after users have scaled its stiffness and added damping.
//
//     if (auto matrices = edited_materials(*model, edits)) use(*matrices); else use(model->matrices);

#include <memory>

#include "engine/mechanics/elasticity.hpp"
#include "engine/simulation/simulation.hpp"

namespace tetfront {

/// Null: nothing differs from the model. Tets whose leaves are all scaled alike have the model's matrices times that;
/// those at the rim of a part are estimated anew, without nonlinear samples. Cost: the tree.
std::shared_ptr<const ElasticityMatrices> edited_materials(const Model& model, const Edits& edits);

}  // namespace tetfront
