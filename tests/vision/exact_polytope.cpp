#include "exact_polytope.h"

#include <cstdlib>
#include <stdexcept>
#include <string>

#include <gmp.h>  // before cddlib, which would take its C++ operators for C

// cddlib's headers choose the arithmetic by this name, and are C.
#define GMPRATIONAL
extern "C" {
#include <cddlib/setoper.h>
// After setoper.h, which it needs.
#include <cddlib/cdd.h>
}

namespace headway::vision::test {

namespace {

void require(dd_ErrorType error) {
  if (error != dd_NoError) throw std::runtime_error("cddlib: error " + std::to_string(error));
}

class Matrix {
 public:
  Matrix(std::size_t rows, dd_RepresentationType representation) {
    static const bool started = (dd_set_global_constants(), true);
    (void)started;
    matrix_ = dd_CreateMatrix(static_cast<dd_rowrange>(rows), 4);
    matrix_->representation = representation;
    matrix_->numbtype = dd_Rational;
  }
  explicit Matrix(dd_MatrixPtr matrix) : matrix_(matrix) {}
  ~Matrix() { dd_FreeMatrix(matrix_); }
  Matrix(const Matrix&) = delete;
  Matrix& operator=(const Matrix&) = delete;

  // cddlib's rows are (b, a): b + a x >= 0, or (1, point), (0, direction).
  void set(std::size_t row, double first, const Eigen::Vector3d& rest) {
    dd_set_d(matrix_->matrix[row][0], first);
    for (int i = 0; i < 3; ++i) dd_set_d(matrix_->matrix[row][i + 1], rest[i]);
  }
  double at(std::size_t row, int column) const { return mpq_get_d(matrix_->matrix[row][column]); }
  Eigen::Vector3d rest(std::size_t row) const { return {at(row, 1), at(row, 2), at(row, 3)}; }
  std::size_t size() const { return static_cast<std::size_t>(matrix_->rowsize); }

  void make_canonical() {
    dd_rowset linear = nullptr, redundant = nullptr;
    dd_rowindex positions = nullptr;
    dd_ErrorType error = dd_NoError;
    dd_MatrixCanonicalize(&matrix_, &linear, &redundant, &positions, &error);
    require(error);
    set_free(linear), set_free(redundant), free(positions);
  }

  dd_MatrixPtr get() const { return matrix_; }

 private:
  dd_MatrixPtr matrix_ = nullptr;
};

}  // namespace

ExactPolytope exact_polytope(const std::vector<Eigen::Vector4d>& rows) {
  Matrix matrix(rows.size(), dd_Inequality);
  for (std::size_t i = 0; i < rows.size(); ++i) matrix.set(i, rows[i].w(), rows[i].head<3>());
  matrix.make_canonical();
  ExactPolytope out;
  for (std::size_t i = 0; i < matrix.size(); ++i)
    out.rows.emplace_back(matrix.at(i, 1), matrix.at(i, 2), matrix.at(i, 3), matrix.at(i, 0));
  dd_ErrorType error = dd_NoError;
  const dd_PolyhedraPtr polyhedron = dd_DDMatrix2Poly(matrix.get(), &error);
  require(error);
  {
    const Matrix generators(dd_CopyGenerators(polyhedron));
    for (std::size_t i = 0; i < generators.size(); ++i) {
      if (generators.at(i, 0) > 0)
        out.corners.push_back(generators.rest(i));
      else
        ++out.directions;
    }
  }
  dd_FreePolyhedra(polyhedron);
  return out;
}

std::size_t exact_hull_vertices(const std::vector<Eigen::Vector3d>& points) {
  Matrix matrix(points.size(), dd_Generator);
  for (std::size_t i = 0; i < points.size(); ++i) matrix.set(i, 1, points[i]);
  matrix.make_canonical();
  return matrix.size();
}

}  // namespace headway::vision::test
