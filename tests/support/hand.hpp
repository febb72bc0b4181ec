#pragma once
// A hand that grabs another point of the surface every second and swings it around, for reports about live use.
//
//     Hand hand(*model);
//     for (int i = 0; i < steps; ++i) { hand.move(simulation, i);  simulation.step(); }

#include <cmath>
#include <numbers>

#include "engine/simulation/simulation.hpp"

namespace tetfront::testing {

class Hand {
 public:
    explicit Hand(const Model& model) : triangles_(model.frame_model->triangles.size()) {
        const auto& box = model.frame_model->rest_box;
        const Vec3 low(box[0], box[1], box[2]), high(box[3], box[4], box[5]);
        centre_ = (low + high) / 2;
        size_ = (high - low).maxCoeff();
    }
    /// Before step `i` of 1/60 s.
    void move(Simulation& simulation, int i) const {
        const auto triangle = static_cast<std::uint32_t>(static_cast<std::size_t>(i / 60) * 397 % triangles_);
        const double angle = 2 * std::numbers::pi * i / 45;
        const Vec3 target = centre_ + size_ * Vec3(std::cos(angle), 0.6 + 0.4 * std::sin(2 * angle), std::sin(angle));
        if (i % 60 == 0) simulation.begin_pull(1, {triangle, Vec3::Constant(1.0 / 3)}, target);
        simulation.move_pull(1, target);
    }

 private:
    std::size_t triangles_;
    Vec3 centre_;
    double size_;
};

}  // namespace tetfront::testing
