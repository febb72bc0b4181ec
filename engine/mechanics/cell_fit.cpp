#include "engine/mechanics/cell_fit.hpp"

#include "engine/base/error.hpp"

#include <cstddef>

namespace tetfront {

double fit_slope(std::span<const double> alphas, std::span<const double> sigmas, const LinearLaw& law) {
    ENSURE(!alphas.empty() && alphas.size() == sigmas.size(), alphas.size(), " and ", sigmas.size());
    std::size_t most = 0;
    double best = sigmas[0] / alphas[0], least_deviation = 0;
    for (std::size_t candidate = 0; candidate < alphas.size(); ++candidate) {
        const double slope = sigmas[candidate] / alphas[candidate];
        std::size_t agreeing = 0;
        double deviation = 0;
        for (std::size_t i = 0; i < alphas.size(); ++i) {
            const double d = law.deviation(alphas[i], slope, sigmas[i]);
            if (d < 1) {
                ++agreeing;
                deviation += d;
            }
        }
        if (agreeing > most || (agreeing == most && deviation < least_deviation)) {
            most = agreeing;
            best = slope;
            least_deviation = deviation;
        }
    }
    double product = 0, square = 0;
    for (std::size_t i = 0; i < alphas.size(); ++i) {
        if (law.deviation(alphas[i], best, sigmas[i]) >= 1) continue;
        product += alphas[i] * sigmas[i];
        square += alphas[i] * alphas[i];
    }
    return square > 0 ? product / square : best;
}

}  // namespace tetfront
