// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/simulator/terrain.h"

#include "drivers/simulator/gradient_noise.h"

namespace cliquevo::drivers::sim {

double Terrain::height(double x, double y) const {
  struct Octave {
    double wavelength_m, amplitude_m;
  };
  // Slopes of about 6 % together: hills, swells, bumps; what is smaller are stones.
  static constexpr Octave kOctaves[] = {{83.0, 3.2}, {37.0, 1.0}, {15.0, 0.28}, {6.3, 0.08}, {3.1, 0.025}};
  double h = 0.0;
  int octave = 0;
  for (const Octave& o : kOctaves) {
    h += o.amplitude_m * gradient_noise(seed_ * 0x51ed2701ULL + static_cast<std::uint64_t>(octave),
                                        x / o.wavelength_m + 0.37 * (octave + 1.0),
                                        y / o.wavelength_m + 0.61 * (octave + 1.0));
    ++octave;
  }
  return h;
}

}  // namespace cliquevo::drivers::sim
