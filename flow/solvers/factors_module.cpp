// The Python module flow_factors: factors of a sparse matrix in single precision, by the library MUMPS.
// PETSc, which the rest of the flow uses, offers MUMPS in double precision only.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <smumps_c.h>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace {

namespace py = pybind11;

using Numbers = py::array_t<int, py::array::c_style>;
using Values = py::array_t<double, py::array::c_style>;
using Columns = py::array_t<double, py::array::f_style>; // MUMPS reads right sides one after the other

// MUMPS's jobs, and its controls by their numbers in its users' guide
enum Job { initialise = -1, end = -2, analyse = 1, factorise = 2, substitute = 3 };
constexpr int output_streams[] = {1, 2, 3}, print_level = 4, workspace_margin = 14;
// MUMPS allows this much more memory than it expects. Where pivoting needs still more, the margin is doubled.
constexpr int margin_percent = 60, largest_margin_percent = 1000;
constexpr int no_room[] = {-8, -9}; // errors: too little memory for integers, for values

/// Factors L U of a matrix. They have some 6 exact digits, and take half the memory and time of double precision.
class Factors {
public:
  /// communicator: that of this process alone, by the number that it has in Fortran. MPI has to be initialised.
  explicit Factors(int communicator) {
    mumps_.par = 1;
    mumps_.sym = 0;
    mumps_.comm_fortran = communicator;
    run(initialise);
    for (const int stream : output_streams)
      control(stream) = -1;
    control(print_level) = 0;
    control(workspace_margin) = margin_percent;
  }
  ~Factors() {
    mumps_.job = end;
    smumps_c(&mumps_);
  }
  Factors(const Factors&) = delete;
  Factors& operator=(const Factors&) = delete;

  /// Factorises the matrix of a CSR pattern, starts (n + 1) and columns (m), with values (m). The order of elimination
  /// is chosen at the first call, so the pattern has to be the same at all calls. Throws std::runtime_error.
  void set_matrix(const Numbers& starts, const Numbers& columns, const Values& values) {
    auto [row, column] = counted_from_1(starts, columns);
    if (values.size() != columns.size() || (analysed_ && (row != row_ || column != column_)))
      throw std::runtime_error("another pattern than at the first factorization");
    values_.assign(values.data(), values.data() + values.size());
    mumps_.a = values_.data();
    if (!analysed_) {
      row_ = std::move(row);
      column_ = std::move(column);
      mumps_.n = static_cast<MUMPS_INT>(starts.size() - 1);
      mumps_.nnz = static_cast<MUMPS_INT8>(row_.size());
      mumps_.irn = row_.data();
      mumps_.jcn = column_.data();
      run(analyse);
    }
    analysed_ = true;
    factorise_with_room();
  }

  /// The solutions (n, k) for the columns of right_sides (n, k). Each column is scaled, so that single precision can
  /// hold it. Throws std::runtime_error.
  Columns solve(const Columns& right_sides) {
    const py::ssize_t size = right_sides.shape(0), count = right_sides.shape(1);
    if (size != mumps_.n)
      throw std::runtime_error("right sides of another length than the matrix");
    if (count == 0)
      return Columns({size, count});
    std::vector<float> work(static_cast<std::size_t>(size * count));
    std::vector<double> scales;
    for (py::ssize_t k = 0; k < count; ++k) {
      const double* given = right_sides.data(0, k);
      double largest = 0;
      for (py::ssize_t i = 0; i < size; ++i)
        largest = std::max(largest, std::abs(given[i]));
      scales.push_back(largest > 0 ? largest : 1);
      for (py::ssize_t i = 0; i < size; ++i)
        work[static_cast<std::size_t>(k * size + i)] = static_cast<float>(given[i] / scales.back());
    }
    mumps_.rhs = work.data();
    mumps_.nrhs = static_cast<MUMPS_INT>(count);
    mumps_.lrhs = mumps_.n;
    run(substitute);
    Columns found({size, count});
    for (py::ssize_t k = 0; k < count; ++k)
      for (py::ssize_t i = 0; i < size; ++i)
        found.mutable_at(i, k) =
            scales[static_cast<std::size_t>(k)] * static_cast<double>(work[static_cast<std::size_t>(k * size + i)]);
    return found;
  }

private:
  MUMPS_INT& control(int number) { return mumps_.icntl[number - 1]; }

  /// Row and column of each entry of a CSR pattern, counted from 1 as MUMPS wants them.
  static std::pair<std::vector<MUMPS_INT>, std::vector<MUMPS_INT>> counted_from_1(const Numbers& starts,
                                                                                  const Numbers& columns) {
    std::vector<MUMPS_INT> row, column(columns.data(), columns.data() + columns.size());
    row.reserve(column.size());
    for (MUMPS_INT i = 1; i < starts.size(); ++i)
      row.insert(row.end(), static_cast<std::size_t>(starts.at(i) - starts.at(i - 1)), i);
    for (MUMPS_INT& one : column)
      ++one;
    return {std::move(row), std::move(column)};
  }

  void factorise_with_room() {
    for (;;) {
      try {
        return run(factorise);
      } catch (const std::runtime_error&) {
        const bool had_room = std::find(std::begin(no_room), std::end(no_room), mumps_.infog[0]) == std::end(no_room);
        if (had_room || control(workspace_margin) > largest_margin_percent)
          throw;
        control(workspace_margin) *= 2;
      }
    }
  }

  void run(Job job) {
    mumps_.job = job;
    smumps_c(&mumps_);
    if (mumps_.infog[0] < 0)
      throw std::runtime_error("INFOG(1) = " + std::to_string(mumps_.infog[0]) +
                               ", INFOG(2) = " + std::to_string(mumps_.infog[1]));
  }

  SMUMPS_STRUC_C mumps_{};
  std::vector<MUMPS_INT> row_, column_;
  std::vector<float> values_;
  bool analysed_ = false;
};

} // namespace

PYBIND11_MODULE(flow_factors, module) {
  module.doc() = "Factors of a sparse matrix in single precision, by MUMPS. Its users' guide explains INFOG.";
  py::class_<Factors>(module, "Factors")
      .def(py::init<int>(), py::arg("communicator"))
      .def("set_matrix", &Factors::set_matrix, py::arg("starts"), py::arg("columns"), py::arg("values"))
      .def("solve", &Factors::solve, py::arg("right_sides"));
}
