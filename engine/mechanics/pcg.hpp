#pragma once
// Preconditioned conjugate gradients on a BlockMatrix, to a tolerance.
//
//     BlockJacobi preconditioner;
//     preconditioner.build(matrix);
//     PcgResult r = pcg.solve(matrix, preconditioner, rhs, x, {.tolerance = 1e-4, .iterations = 2000});
//     if (!r.converged) ...                      // x is the best so far; the caller says so to the user
//
// The residual is measured in the preconditioner's norm, sqrt(r^T B r) relative to that of the right-hand side, which
// is close to the energy norm of the error and indifferent to units and stiffness contrasts.

#include "engine/mechanics/block_matrix.hpp"

namespace tetfront {

/// z = B r, B symmetric positive definite and near the inverse of the matrix.
class Preconditioner {
 public:
    virtual ~Preconditioner() = default;
    virtual void apply(const DofVector& r, DofVector& z) const = 0;
};

/// The inverted 3x3 diagonal blocks.
class BlockJacobi : public Preconditioner {
 public:
    void build(const BlockMatrix& matrix);
    void apply(const DofVector& r, DofVector& z) const override;

 private:
    std::vector<Mat3> inverse_;  // [dofs]
};

struct PcgLimits {
    double tolerance = 1e-4;  // relative
    int iterations = 2000;
};
struct PcgResult {
    bool converged = true;
    int iterations = 0;
    double residual = 0;  // relative, at the end
};

class Pcg {
 public:
    /// Solves A x = b. x: start value in, solution out.
    PcgResult solve(const BlockMatrix& a, const Preconditioner& preconditioner, const DofVector& b, DofVector& x,
                    const PcgLimits& limits);

 private:
    DofVector r_, z_, p_, q_;  // kept to save allocations
};

}  // namespace tetfront
