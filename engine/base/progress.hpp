#pragma once
// How far something long is.
//
//     build_model(scene, [](const std::string& what, double fraction) { ... });

#include <functional>
#include <string>

namespace tetfront {

/// What is being done (a noun phrase) and the fraction of it that is done, 0..1. Called on the calling thread. May be empty.
using Progress = std::function<void(const std::string& what, double fraction)>;

}  // namespace tetfront
