#include "measure/outline_noise.hpp"
#include <complex>

namespace anatomy {
namespace {

using Complex = std::complex<double>;
constexpr double shortest_wave = 0.6; // mm; at this wavelength segmented walls have noise, and lumens hardly any shape
constexpr double edges_per_wave = 3;  // a wave of fewer edges is lost between the wall's points
constexpr int first_mode = 4;         // modes 0 to 3 (size, place, ellipse, triangle) are the lumen's shape
constexpr int fewest_modes = 3;       // least number of modes over which the noise is averaged
// Number of edges that a line crosses per edge length, in a mesh of equilateral triangles.
constexpr double random_crossings = 2.2;

double length_of(const std::vector<Vec2>& outline) {
  double length = 0;
  for (std::size_t i = 0; i < outline.size(); ++i)
    length += (outline[(i + 1) % outline.size()] - outline[i]).norm();
  return length;
}

// n points at equal distances along the outline of this length (mm), as complex numbers x + i y.
std::vector<Complex> resample_evenly(const std::vector<Vec2>& outline, std::size_t n, double length) {
  std::vector<Complex> points;
  double begin = 0;
  for (std::size_t i = 0; i < outline.size() && points.size() < n; ++i) {
    const Vec2 &a = outline[i], &b = outline[(i + 1) % outline.size()];
    const double step = (b - a).norm();
    for (double at = 0; points.size() < n;
         points.emplace_back((1 - at) * a.x() + at * b.x(), (1 - at) * a.y() + at * b.y())) {
      at = step > 0 ? (static_cast<double>(points.size()) * length / static_cast<double>(n) - begin) / step : 2;
      if (at > 1)
        break;
    }
    begin += step;
  }
  while (points.size() < n)
    points.emplace_back(outline.front().x(), outline.front().y());
  return points;
}

// Fourier modes of n values round a closed outline. Mode m is (1/n) sum of value_k exp(-2 pi i m k / n).
class FourierModes {
public:
  explicit FourierModes(std::size_t n) {
    for (std::size_t k = 0; k < n; ++k)
      turn_.push_back(std::polar(1.0, 2 * pi * static_cast<double>(k) / static_cast<double>(n)));
  }
  Complex turn(int m, std::size_t k) const {
    const auto n = static_cast<std::ptrdiff_t>(turn_.size());
    const std::ptrdiff_t at = m * static_cast<std::ptrdiff_t>(k) % n;
    return turn_[static_cast<std::size_t>(at < 0 ? at + n : at)];
  }
  Complex amplitude(const std::vector<Complex>& values, int m) const {
    Complex sum = 0;
    for (std::size_t k = 0; k < values.size(); ++k)
      sum += values[k] * std::conj(turn(m, k));
    return sum / static_cast<double>(values.size());
  }

private:
  std::vector<Complex> turn_;
};

// Signed distance (mm) of each point from a smooth outline, along that outline's normal. The smooth outline is the sum
// of the points' Fourier modes -(modes - 1) to modes - 1.
std::vector<Complex> distances_from_smooth(const std::vector<Complex>& points, const FourierModes& fourier, int modes) {
  std::vector<Complex> smooth(points.size()), tangent(points.size()), off;
  for (int m = 1 - modes; m < modes; ++m) {
    const Complex wave = fourier.amplitude(points, m);
    for (std::size_t k = 0; k < points.size(); ++k) {
      smooth[k] += wave * fourier.turn(m, k);
      tangent[k] += Complex(0, m) * wave * fourier.turn(m, k);
    }
  }
  for (std::size_t k = 0; k < points.size(); ++k) {
    const double length = std::abs(tangent[k]);
    off.emplace_back(length > 0 ? ((points[k] - smooth[k]) * std::conj(Complex(0, -1) * tangent[k])).real() / length
                                : 0);
  }
  return off;
}

} // namespace

double edge_by_crossings(const std::vector<Vec2>& outline) {
  return random_crossings * length_of(outline) / static_cast<double>(outline.size());
}

double mean_radius_scatter(const std::vector<Vec2>& outline, double edge) {
  const double length = length_of(outline), wave = std::max(shortest_wave, edges_per_wave * edge);
  const int last = static_cast<int>(length / wave);
  const int first = std::max(first_mode, static_cast<int>(std::ceil(length / (2 * wave))));
  if (last - first + 1 < fewest_modes)
    return -1;
  const FourierModes fourier(static_cast<std::size_t>(std::max(128, 5 * last)));
  const std::vector<Complex> off = distances_from_smooth(
      resample_evenly(outline, static_cast<std::size_t>(std::max(128, 5 * last)), length), fourier, first);
  double power = 0;
  for (int m = first; m <= last; ++m) {
    // The wall is straight between its points, which weakens a wave of its noise by sinc^2. The division undoes this.
    const double x = pi * m * edge / length, passed = std::pow(std::sin(x) / x, 2);
    power += std::norm(fourier.amplitude(off, m)) / (passed * passed);
  }
  return std::sqrt(power / (last - first + 1));
}

} // namespace anatomy
