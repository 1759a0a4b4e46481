// Wireloom for C++17: wireloom.h with handles that free themselves, and errors as exceptions.
//
// Structs such as WireloomBranch are those of wireloom.h; their pointers are valid as long as the object they were read
// from, so a struct with pointers is not read from a temporary. Objects can be moved, but not copied.

#ifndef WIRELOOM_HPP
#define WIRELOOM_HPP

#include "wireloom.h"

#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace wireloom {

/// Why a function failed.
class Error : public std::runtime_error {
  public:
    explicit Error(const WireloomError &error)
        : std::runtime_error(error.message), code(error.code), line(error.line), column(error.column),
          suggestion(error.suggestion) {}

    WireloomCode code;
    /// Line and column in the scenario's text, from 1; 0: no place.
    std::uint32_t line, column;
    /// What to do about it; may be empty.
    std::string suggestion;
};

namespace detail {

/// Calls a function of the library; throws what it says if it fails.
template <class Call> void checked(Call call) {
    WireloomError error{};
    error.size = sizeof error;
    if (call(&error) != WIRELOOM_CODE_OK) {
        throw Error(error);
    }
}

/// A struct with its size set.
template <class Struct> Struct sized() {
    Struct one{};
    one.size = sizeof one;
    return one;
}

/// A struct that a function of the library fills.
template <class Struct, class Call> Struct filled(Call call) {
    Struct out = sized<Struct>();
    checked([&](WireloomError *error) { return call(&out, error); });
    return out;
}

/// A handle that is freed with its owner.
template <class Handle, WireloomCode (*Free)(Handle)> class Owned {
  public:
    explicit Owned(Handle own = {}) : handle(own) {}
    Owned(Owned &&other) noexcept : handle(std::exchange(other.handle, Handle{})) {}
    Owned &operator=(Owned &&other) noexcept {
        if (this != &other) {
            Free(handle);
            handle = std::exchange(other.handle, Handle{});
        }
        return *this;
    }
    Owned(const Owned &) = delete;
    Owned &operator=(const Owned &) = delete;
    ~Owned() { Free(handle); }

    Handle handle;
};

/// The text of a handle, which is freed.
inline std::string taken(WireloomText text) {
    Owned<WireloomText, wireloom_text_free> own(text);
    const char *bytes = nullptr;
    std::size_t length = 0;
    checked([&](WireloomError *error) { return wireloom_text_get(text, &bytes, &length, error); });
    return std::string(bytes, length);
}

} // namespace detail

/// Cancels computations from another thread.
class Cancel {
  public:
    Cancel() {
        detail::checked([this](WireloomError *error) { return wireloom_cancel_new(&own.handle, error); });
    }
    void request() {
        detail::checked([this](WireloomError *error) { return wireloom_cancel_request(own.handle, error); });
    }
    void reset() {
        detail::checked([this](WireloomError *error) { return wireloom_cancel_reset(own.handle, error); });
    }
    WireloomCancel handle() const { return own.handle; }

  private:
    detail::Owned<WireloomCancel, wireloom_cancel_free> own;
};

/// The result of a run, or of a session at one moment.
class Result {
  public:
    explicit Result(WireloomResult result) : own(result) {}
    WireloomResult handle() const { return own.handle; }

    WireloomSummary summary() const & {
        return detail::filled<WireloomSummary>(
            [&](auto *out, WireloomError *error) { return wireloom_result_get(own.handle, out, error); });
    }
    WireloomStep step(std::size_t step) const & {
        return detail::filled<WireloomStep>(
            [&](auto *out, WireloomError *error) { return wireloom_result_step(own.handle, step, out, error); });
    }
    WireloomBranch branch(std::size_t step, std::size_t index) const & {
        return detail::filled<WireloomBranch>([&](auto *out, WireloomError *error) {
            return wireloom_result_branch(own.handle, step, index, out, error);
        });
    }
    WireloomBranch branch(std::size_t step, const std::string &name) const & {
        return branch(step, find(step, WIRELOOM_FAMILY_BRANCH, name));
    }
    WireloomConstraint constraint(std::size_t step, std::size_t index) const & {
        return detail::filled<WireloomConstraint>([&](auto *out, WireloomError *error) {
            return wireloom_result_constraint(own.handle, step, index, out, error);
        });
    }
    WireloomConstraint constraint(std::size_t step, const std::string &name) const & {
        return constraint(step, find(step, WIRELOOM_FAMILY_CONSTRAINT, name));
    }
    WireloomPlace joint(std::size_t step, std::size_t index) const & {
        return detail::filled<WireloomPlace>([&](auto *out, WireloomError *error) {
            return wireloom_result_joint(own.handle, step, index, out, error);
        });
    }
    WireloomPlace marker(std::size_t step, std::size_t index) const & {
        return detail::filled<WireloomPlace>([&](auto *out, WireloomError *error) {
            return wireloom_result_marker(own.handle, step, index, out, error);
        });
    }
    WireloomBodyState body(std::size_t step, std::size_t index) const & {
        return detail::filled<WireloomBodyState>([&](auto *out, WireloomError *error) {
            return wireloom_result_body(own.handle, step, index, out, error);
        });
    }
    WireloomEvent event(std::size_t index) const & {
        return detail::filled<WireloomEvent>(
            [&](auto *out, WireloomError *error) { return wireloom_result_event(own.handle, index, out, error); });
    }
    WireloomRequirement requirement(std::size_t index) const & {
        return detail::filled<WireloomRequirement>([&](auto *out, WireloomError *error) {
            return wireloom_result_requirement(own.handle, index, out, error);
        });
    }
    const char *note(std::size_t index) const & {
        const char *note = nullptr;
        detail::checked([&](WireloomError *error) { return wireloom_result_note(own.handle, index, &note, error); });
        return note;
    }
    /// Index of a part by its name.
    std::size_t find(std::size_t step, WireloomFamily family, const std::string &name) const {
        std::size_t index = 0;
        detail::checked([&](WireloomError *error) {
            return wireloom_result_find(own.handle, step, family, name.c_str(), &index, error);
        });
        return index;
    }

    // Their pointers would end with the temporary.
    WireloomSummary summary() const && = delete;
    WireloomStep step(std::size_t) const && = delete;
    WireloomBranch branch(std::size_t, std::size_t) const && = delete;
    WireloomBranch branch(std::size_t, const std::string &) const && = delete;
    WireloomConstraint constraint(std::size_t, std::size_t) const && = delete;
    WireloomConstraint constraint(std::size_t, const std::string &) const && = delete;
    WireloomPlace joint(std::size_t, std::size_t) const && = delete;
    WireloomPlace marker(std::size_t, std::size_t) const && = delete;
    WireloomBodyState body(std::size_t, std::size_t) const && = delete;
    WireloomEvent event(std::size_t) const && = delete;
    WireloomRequirement requirement(std::size_t) const && = delete;
    const char *note(std::size_t) const && = delete;

  private:
    detail::Owned<WireloomResult, wireloom_result_free> own;
};

/// A harness that is moved by hand.
class Session {
  public:
    explicit Session(WireloomSession session) : own(session) {}
    WireloomSession handle() const { return own.handle; }

    /// Moves a constraint; a null pointer keeps its position, or its orientation.
    void move(const char *constraint, const double *position, const double *orientation = nullptr) {
        detail::checked([&](WireloomError *error) {
            return wireloom_session_move(own.handle, constraint, position, orientation, error);
        });
    }
    /// Moves a body of the surroundings.
    void move_body(const char *body, const double *position, const double *orientation = nullptr) {
        detail::checked([&](WireloomError *error) {
            return wireloom_session_move_body(own.handle, body, position, orientation, error);
        });
    }
    /// Drives a joint of a mechanism to a value, rad or m.
    void drive(const char *joint, double value) {
        detail::checked(
            [&](WireloomError *error) { return wireloom_session_drive(own.handle, joint, value, error); });
    }
    /// Takes hold of the cable, with a new handle of this name.
    void hold(const char *branch, double s, const char *name) {
        detail::checked(
            [&](WireloomError *error) { return wireloom_session_hold(own.handle, branch, s, name, error); });
    }
    void release(const char *constraint) {
        detail::checked(
            [&](WireloomError *error) { return wireloom_session_release(own.handle, constraint, error); });
    }
    void set(const char *key, const char *json) {
        detail::checked([&](WireloomError *error) { return wireloom_session_set(own.handle, key, json, error); });
    }
    void undo() {
        detail::checked([&](WireloomError *error) { return wireloom_session_undo(own.handle, error); });
    }
    /// The current equilibrium.
    Result result() const {
        WireloomResult result{};
        detail::checked([&](WireloomError *error) { return wireloom_session_result(own.handle, &result, error); });
        return Result(result);
    }
    /// The scenario as TOML, with all that was done by hand.
    std::string text() const {
        WireloomText text{};
        detail::checked([&](WireloomError *error) { return wireloom_session_text(own.handle, &text, error); });
        return detail::taken(text);
    }

  private:
    detail::Owned<WireloomSession, wireloom_session_free> own;
};

/// Derivatives of results by numbers of a scenario.
class Sensitivities {
  public:
    explicit Sensitivities(WireloomSensitivities sensitivities) : own(sensitivities) {}
    WireloomSensitivities handle() const { return own.handle; }

    WireloomAnswer answer() const & {
        return detail::filled<WireloomAnswer>(
            [&](auto *out, WireloomError *error) { return wireloom_sensitivities_get(own.handle, out, error); });
    }
    WireloomParameter parameter(std::size_t index) const & {
        return detail::filled<WireloomParameter>([&](auto *out, WireloomError *error) {
            return wireloom_sensitivities_parameter(own.handle, index, out, error);
        });
    }
    WireloomOutput output(std::size_t index) const & {
        return detail::filled<WireloomOutput>([&](auto *out, WireloomError *error) {
            return wireloom_sensitivities_output(own.handle, index, out, error);
        });
    }
    WireloomDerivative derivative(std::size_t output, std::size_t parameter) const & {
        return detail::filled<WireloomDerivative>([&](auto *out, WireloomError *error) {
            return wireloom_sensitivities_derivative(own.handle, output, parameter, out, error);
        });
    }

    // Their pointers would end with the temporary.
    WireloomAnswer answer() const && = delete;
    WireloomParameter parameter(std::size_t) const && = delete;
    WireloomOutput output(std::size_t) const && = delete;
    WireloomDerivative derivative(std::size_t, std::size_t) const && = delete;

  private:
    detail::Owned<WireloomSensitivities, wireloom_sensitivities_free> own;
};

/// What a check found.
struct Diagnostic {
    WireloomSeverity severity;
    std::uint32_t line, column;
    std::string message, suggestion;
};

/// A scenario: a text, and the files that it names.
class Scenario {
  public:
    explicit Scenario(std::string_view text, const char *folder = nullptr) {
        detail::checked([&](WireloomError *error) {
            return wireloom_scenario_new(text.data(), text.size(), folder, &own.handle, error);
        });
    }
    static Scenario read(const char *path) {
        WireloomScenario scenario{};
        detail::checked([&](WireloomError *error) { return wireloom_scenario_read(path, &scenario, error); });
        return Scenario(scenario);
    }
    WireloomScenario handle() const { return own.handle; }

    void set(const char *key, const char *json) {
        detail::checked([&](WireloomError *error) { return wireloom_scenario_set(own.handle, key, json, error); });
    }
    void add_file(const char *name, const void *bytes, std::size_t count) {
        detail::checked([&](WireloomError *error) {
            return wireloom_scenario_add_file(own.handle, name, static_cast<const std::uint8_t *>(bytes), count, error);
        });
    }
    /// Adds a body of the surroundings; its size is set here.
    void add_body(WireloomBody body) {
        body.size = sizeof body;
        detail::checked([&](WireloomError *error) { return wireloom_scenario_add_body(own.handle, &body, error); });
    }
    std::string text() const {
        WireloomText text{};
        detail::checked([&](WireloomError *error) { return wireloom_scenario_text(own.handle, &text, error); });
        return detail::taken(text);
    }
    /// The bytes of a file that the scenario keeps, such as "NAME.obj" with the surface of the body NAME.
    std::string file(const std::string &name) const {
        WireloomText bytes{};
        detail::checked(
            [&](WireloomError *error) { return wireloom_scenario_file(own.handle, name.c_str(), &bytes, error); });
        return detail::taken(bytes);
    }
    std::vector<Diagnostic> check() const {
        WireloomDiagnostics list{};
        std::size_t count = 0;
        detail::checked(
            [&](WireloomError *error) { return wireloom_scenario_check(own.handle, &list, &count, error); });
        detail::Owned<WireloomDiagnostics, wireloom_diagnostics_free> all(list);
        std::vector<Diagnostic> found;
        for (std::size_t k = 0; k < count; k++) {
            WireloomDiagnostic one = detail::sized<WireloomDiagnostic>();
            detail::checked([&](WireloomError *error) { return wireloom_diagnostics_get(list, k, &one, error); });
            found.push_back({one.severity, one.line, one.column, one.message, one.suggestion});
        }
        return found;
    }
    /// Carries it out. `on_progress` is called at the end of every increment, and ends the run by returning false; what
    /// it throws ends the run, too, and comes out here.
    Result run(std::function<bool(const WireloomProgress &)> on_progress = nullptr,
               const Cancel *cancel = nullptr) const {
        struct Watch {
            std::function<bool(const WireloomProgress &)> call;
            std::exception_ptr thrown;
        } watch{std::move(on_progress), nullptr};
        WireloomRunOptions options = detail::sized<WireloomRunOptions>();
        options.user = &watch;
        if (watch.call) {
            options.on_progress = [](void *user, const WireloomProgress *progress) {
                Watch &watching = *static_cast<Watch *>(user);
                try {
                    return watching.call(*progress) ? 0 : 1;
                } catch (...) {
                    watching.thrown = std::current_exception();
                    return 1;
                }
            };
        }
        if (cancel != nullptr) {
            options.cancel = cancel->handle();
        }
        WireloomResult ended{};
        WireloomError error = detail::sized<WireloomError>();
        const WireloomCode code = wireloom_run(own.handle, &options, &ended, &error);
        Result result(ended);
        if (watch.thrown) {
            std::rethrow_exception(watch.thrown);
        }
        if (code != WIRELOOM_CODE_OK) {
            throw Error(error);
        }
        return result;
    }
    /// Opens a session. `cancel` cancels what it does.
    Session session(const Cancel *cancel = nullptr) const {
        WireloomSession opened{};
        const WireloomCancel none{};
        detail::checked([&](WireloomError *error) {
            return wireloom_session_open(own.handle, cancel == nullptr ? none : cancel->handle(), &opened, error);
        });
        return Session(opened);
    }

    /// Derivatives of outputs by the numbers at keys, at the end of a step; a null pointer: the last one.
    Sensitivities sensitivities(const std::vector<const char *> &of, const std::vector<const char *> &by,
                                const char *step = nullptr, const Cancel *cancel = nullptr) const {
        WireloomQuestion question = detail::sized<WireloomQuestion>();
        question.of = of.data();
        question.of_count = of.size();
        question.by = by.data();
        question.by_count = by.size();
        question.step = step;
        if (cancel != nullptr) {
            question.cancel = cancel->handle();
        }
        WireloomSensitivities found{};
        detail::checked([&](WireloomError *error) {
            return wireloom_sensitivities_new(own.handle, &question, &found, error);
        });
        return Sensitivities(found);
    }

  private:
    explicit Scenario(WireloomScenario scenario) : own(scenario) {}

    detail::Owned<WireloomScenario, wireloom_scenario_free> own;
};

} // namespace wireloom

#endif // WIRELOOM_HPP
