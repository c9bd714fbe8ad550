// CHOLMOD's supernodal Cholesky behind the seam (profile full: it is GPL in parts).
#include "skinfield/base/error.h"
#include "skinfield/base/parallel.h"
#include "solve/factor_backend.h"

#if SKINFIELD_HAVE_CHOLMOD
#include <cholmod.h>

#include <cmath>
#endif

namespace skinfield {

#if SKINFIELD_HAVE_CHOLMOD
namespace {

constexpr std::size_t kColumnsPerBlock = 10;

/// Settings and workspace. CHOLMOD writes into it, so that each thread needs its own.
class Common {
 public:
  Common() {
    cholmod_start(&common_);
    common_.print = 0;
    common_.supernodal = CHOLMOD_SUPERNODAL;
    common_.final_ll = 1;
  }
  ~Common() { cholmod_finish(&common_); }
  Common(const Common&) = delete;
  Common& operator=(const Common&) = delete;
  cholmod_common* get() { return &common_; }

 private:
  cholmod_common common_;
};

class CholmodFactor : public SparseFactor::Backend {
 public:
  ~CholmodFactor() override { release(); }

  void analyse(const SparseRows& A) override {
    release();
    cholmod_sparse view = sparse(A);
    factor_ = cholmod_analyze(&view, common_.get());
    if (!factor_) throw_failure("analysis");
  }

  void factor(const SparseRows& A, PanelStorage) override {
    cholmod_sparse view = sparse(A);
    cholmod_factorize(&view, factor_, common_.get());
    const int status = common_.get()->status;
    if (status == CHOLMOD_NOT_POSDEF) {
      throw_not_positive_definite(static_cast<const int*>(factor_->Perm)[factor_->minor]);
    }
    if (status < 0) throw_failure("factorisation");
    check_pivots(A);
  }

  using SparseFactor::Backend::solve;
  void solve(RowMatrix& B) const override {
    const auto columns = static_cast<std::size_t>(B.cols());
    parallel_blocks(columns, kColumnsPerBlock, [&](std::size_t begin, std::size_t end) {
      const auto first = static_cast<Eigen::Index>(begin);
      const auto count = static_cast<Eigen::Index>(end - begin);
      Eigen::MatrixXd block = B.middleCols(first, count);
      cholmod_dense view{};
      view.nrow = view.d = static_cast<std::size_t>(block.rows());
      view.ncol = static_cast<std::size_t>(block.cols());
      view.nzmax = view.nrow * view.ncol;
      view.x = block.data();
      view.xtype = CHOLMOD_REAL;
      view.dtype = CHOLMOD_DOUBLE;
      Common local;
      cholmod_dense* x = cholmod_solve(CHOLMOD_A, factor_, &view, local.get());
      if (!x) throw SolveError("CHOLMOD ran out of memory", "sparse solve");
      B.middleCols(first, count) = Eigen::Map<const Eigen::MatrixXd>(
          static_cast<const double*>(x->x), block.rows(), block.cols());
      cholmod_free_dense(&x, local.get());
    });
  }

  std::int64_t nonzeros() const override { return static_cast<std::int64_t>(common_.get()->lnz); }

 private:
  void release() {
    if (factor_) cholmod_free_factor(&factor_, common_.get());
    factor_ = nullptr;
  }

  [[noreturn]] void throw_failure(const char* stage) const {
    const bool memory = common_.get()->status == CHOLMOD_OUT_OF_MEMORY;
    throw SolveError(memory ? "out of memory" : "CHOLMOD failed", std::string("sparse ") + stage,
                     "use fewer nodes");
  }

  /// A singular matrix can leave a tiny positive pivot behind; that is no pivot either.
  void check_pivots(const SparseRows& A) const {
    const auto* super = static_cast<const int*>(factor_->super);
    const auto* pi = static_cast<const int*>(factor_->pi);
    const auto* px = static_cast<const int*>(factor_->px);
    const auto* x = static_cast<const double*>(factor_->x);
    const auto* perm = static_cast<const int*>(factor_->Perm);
    const Vector diagonal = A.diagonal();
    for (std::size_t s = 0; s < factor_->nsuper; ++s) {
      const int rows = pi[s + 1] - pi[s];
      for (int k = 0; k < super[s + 1] - super[s]; ++k) {
        const double pivot = x[px[s] + static_cast<std::ptrdiff_t>(k) * (rows + 1)];
        const int original = perm[super[s] + k];
        if (!(pivot * pivot > 1e-15 * diagonal[original])) throw_not_positive_definite(original);
      }
    }
  }

  /// A is symmetric with both triangles stored: its rows are columns; CHOLMOD reads one triangle.
  static cholmod_sparse sparse(const SparseRows& A) {
    cholmod_sparse view{};
    view.nrow = view.ncol = static_cast<std::size_t>(A.rows());
    view.nzmax = static_cast<std::size_t>(A.nonZeros());
    view.p = const_cast<std::int32_t*>(A.outerIndexPtr());
    view.i = const_cast<std::int32_t*>(A.innerIndexPtr());
    view.x = const_cast<double*>(A.valuePtr());
    view.stype = -1;
    view.itype = CHOLMOD_INT;
    view.xtype = CHOLMOD_REAL;
    view.dtype = CHOLMOD_DOUBLE;
    view.sorted = 1;
    view.packed = 1;
    return view;
  }

  mutable Common common_;
  cholmod_factor* factor_ = nullptr;
};

}  // namespace

std::unique_ptr<SparseFactor::Backend> make_cholmod_factor() {
  return std::make_unique<CholmodFactor>();
}
#else
std::unique_ptr<SparseFactor::Backend> make_cholmod_factor() { return nullptr; }
#endif

}  // namespace skinfield
