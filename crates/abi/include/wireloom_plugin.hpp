// Plugins in C++20: classes instead of tables of functions, and no exception leaves the plugin.
//
// A constraint is a class with
//     T(const WireloomConstraintSpec &spec, WireloomDescription &description);
//     void evaluate(const WireloomSituation &at, WireloomEvaluation &out) const;
// and, where wanted,
//     void target(const WireloomPose &base, double progress, WireloomPose &to) const;
//     void commit(const WireloomSituation &at, double *memory) const;
//     void report(const WireloomSituation &at, double *values) const;
// A joint model is a class with
//     T(const WireloomJointSpec &spec, WireloomJointDescription &description);
//     void evaluate(const double *frames, WireloomJointEvaluation &out) const;
// and, where wanted,
//     void commit(const double *frames, double *memory) const;
// A rod is a class with
//     T(const WireloomRodSpec &spec, WireloomRodDescription &description);
// and one or both of
//     void stretch(const double *strains, WireloomRodResponse &out) const;
//     void bend(const double *strains, WireloomRodResponse &out) const;
// and, if it remembers (`memory_count` of its description),
//     void commit(const double *strains, WireloomRodCommit &committed) const;
// The description comes with has_stretch and has_bend set for those that there are.
// All rules of wireloom_plugin.h hold. A function refuses by throwing wireloom::Refusal. One that is private, not const
// or takes other arguments would not be called: it does not compile. So no class is final, and nothing else in it has
// one of these names.

#ifndef WIRELOOM_PLUGIN_HPP
#define WIRELOOM_PLUGIN_HPP

#include "wireloom_plugin.h"
#include <cstdio>
#include <exception>
#include <stdexcept>
#include <type_traits>

namespace wireloom {

/// What a plugin throws to refuse: WIRELOOM_STATUS_ERROR with this text. Any other exception is WIRELOOM_STATUS_PANIC.
struct Refusal : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// Calls `work`; an exception becomes a status with its text.
template <class Work>
int32_t guarded(WireloomText *message, Work work) noexcept {
    const auto say = [message](const char *words) { std::snprintf(message->data, message->capacity, "%s", words); };
    try {
        work();
        return WIRELOOM_STATUS_OK;
    } catch (const Refusal &refusal) {
        say(refusal.what());
        return WIRELOOM_STATUS_ERROR;
    } catch (const std::exception &error) {
        say(error.what());
    } catch (...) {
        say("an exception that is no std::exception");
    }
    return WIRELOOM_STATUS_PANIC;
}

// Whether T has a member NAME, of any type and access: NAME is then ambiguous in a class derived from T and from
// another one that has it too. A final class has none.
#define WIRELOOM_MEMBER(NAME)                                                                                         \
    struct With_##NAME {                                                                                              \
        int NAME;                                                                                                     \
    };                                                                                                                \
    template <class T, bool = std::is_final_v<T>>                                                                     \
    struct Beside_##NAME : T, With_##NAME {};                                                                         \
    template <class T>                                                                                                \
    struct Beside_##NAME<T, true> : With_##NAME {};                                                                   \
    template <class T>                                                                                                \
    constexpr bool names_##NAME = !requires { &Beside_##NAME<T>::NAME; };

WIRELOOM_MEMBER(target)
WIRELOOM_MEMBER(commit)
WIRELOOM_MEMBER(report)
WIRELOOM_MEMBER(stretch)
WIRELOOM_MEMBER(bend)
#undef WIRELOOM_MEMBER

// Refuses a class whose functions would not be found.
#define WIRELOOM_NOT_FINAL                                                                                            \
    static_assert(!std::is_final_v<T>, "remove `final` from this class: the header derives from it to look at its "    \
                                       "functions")
#define WIRELOOM_CALLABLE(FOUND, NAME, SIGNATURE)                                                                     \
    static_assert(FOUND, "`" NAME "` of this class cannot be called: declare it public and const, `" SIGNATURE         \
                         "`, or give it another name if it is something else")

/// The functions of a constraint of class T.
template <class T>
WireloomConstraintKind constraint_functions(uint32_t stations_min = 1, uint32_t stations_max = 1) {
    constexpr bool evaluates =
        requires(const T &t, const WireloomSituation &at, WireloomEvaluation &out) { t.evaluate(at, out); };
    constexpr bool has_target =
        requires(const T &t, const WireloomPose &base, WireloomPose &to) { t.target(base, 0.0, to); };
    constexpr bool has_commit =
        requires(const T &t, const WireloomSituation &at, double *memory) { t.commit(at, memory); };
    constexpr bool has_report =
        requires(const T &t, const WireloomSituation &at, double *values) { t.report(at, values); };
    WIRELOOM_NOT_FINAL;
    WIRELOOM_CALLABLE(evaluates, "evaluate",
                      "void evaluate(const WireloomSituation &at, WireloomEvaluation &out) const");
    WIRELOOM_CALLABLE(has_target || !names_target<T>, "target",
                      "void target(const WireloomPose &base, double progress, WireloomPose &to) const");
    WIRELOOM_CALLABLE(has_commit || !names_commit<T>, "commit",
                      "void commit(const WireloomSituation &at, double *memory) const");
    WIRELOOM_CALLABLE(has_report || !names_report<T>, "report",
                      "void report(const WireloomSituation &at, double *values) const");
    WireloomConstraintKind all{};
    all.size = sizeof all;
    all.stations_min = stations_min;
    all.stations_max = stations_max;
    all.create = [](const WireloomKind *, const WireloomConstraintSpec *spec, void **instance,
                    WireloomDescription *description, WireloomText *message) {
        return guarded(message, [&] { *instance = new T(*spec, *description); });
    };
    all.destroy = [](void *instance) { delete static_cast<T *>(instance); };
    if constexpr (evaluates) {
        all.evaluate = [](const void *instance, const WireloomSituation *at, WireloomEvaluation *out,
                          WireloomText *message) {
            return guarded(message, [&] { static_cast<const T *>(instance)->evaluate(*at, *out); });
        };
    }
    if constexpr (has_target) {
        all.target = [](const void *instance, const WireloomPose *base, double progress, WireloomPose *to,
                        WireloomText *message) {
            return guarded(message, [&] { static_cast<const T *>(instance)->target(*base, progress, *to); });
        };
    }
    if constexpr (has_commit) {
        all.commit = [](const void *instance, const WireloomSituation *at, double *memory, WireloomText *message) {
            return guarded(message, [&] { static_cast<const T *>(instance)->commit(*at, memory); });
        };
    }
    if constexpr (has_report) {
        all.report = [](const void *instance, const WireloomSituation *at, double *values, WireloomText *message) {
            return guarded(message, [&] { static_cast<const T *>(instance)->report(*at, values); });
        };
    }
    return all;
}

/// The functions of a joint model of class T.
template <class T>
WireloomJointKind joint_functions() {
    constexpr bool evaluates =
        requires(const T &t, const double *frames, WireloomJointEvaluation &out) { t.evaluate(frames, out); };
    constexpr bool has_commit =
        requires(const T &t, const double *frames, double *memory) { t.commit(frames, memory); };
    WIRELOOM_NOT_FINAL;
    WIRELOOM_CALLABLE(evaluates, "evaluate", "void evaluate(const double *frames, WireloomJointEvaluation &out) const");
    WIRELOOM_CALLABLE(has_commit || !names_commit<T>, "commit",
                      "void commit(const double *frames, double *memory) const");
    WireloomJointKind all{};
    all.size = sizeof all;
    all.create = [](const WireloomKind *, const WireloomJointSpec *spec, void **instance,
                    WireloomJointDescription *description, WireloomText *message) {
        return guarded(message, [&] { *instance = new T(*spec, *description); });
    };
    all.destroy = [](void *instance) { delete static_cast<T *>(instance); };
    if constexpr (evaluates) {
        all.evaluate = [](const void *instance, const double *frames, WireloomJointEvaluation *out,
                          WireloomText *message) {
            return guarded(message, [&] { static_cast<const T *>(instance)->evaluate(frames, *out); });
        };
    }
    if constexpr (has_commit) {
        all.commit = [](const void *instance, const double *frames, double *memory, WireloomText *message) {
            return guarded(message, [&] { static_cast<const T *>(instance)->commit(frames, memory); });
        };
    }
    return all;
}

/// Whether a rod has a law of stretch and shear.
template <class T>
constexpr bool has_stretch = requires(const T &t, const double *s, WireloomRodResponse &out) { t.stretch(s, out); };

/// Whether a rod has a law of bending and twist.
template <class T>
constexpr bool has_bend = requires(const T &t, const double *s, WireloomRodResponse &out) { t.bend(s, out); };

/// The functions of a rod of class T.
template <class T>
WireloomRodKind rod_functions() {
    WIRELOOM_NOT_FINAL;
    WIRELOOM_CALLABLE(has_stretch<T> || !names_stretch<T>, "stretch",
                      "void stretch(const double *strains, WireloomRodResponse &out) const");
    WIRELOOM_CALLABLE(has_bend<T> || !names_bend<T>, "bend",
                      "void bend(const double *strains, WireloomRodResponse &out) const");
    static_assert(has_stretch<T> || has_bend<T> || names_stretch<T> || names_bend<T> || std::is_final_v<T>,
                  "this class has no law: declare `stretch`, `bend` or both");
    constexpr bool has_commit =
        requires(const T &t, const double *s, WireloomRodCommit &committed) { t.commit(s, committed); };
    WIRELOOM_CALLABLE(has_commit || !names_commit<T>, "commit",
                      "void commit(const double *strains, WireloomRodCommit &committed) const");
    WireloomRodKind all{};
    all.size = sizeof all;
    all.create = [](const WireloomKind *, const WireloomRodSpec *spec, void **instance,
                    WireloomRodDescription *description, WireloomText *message) {
        return guarded(message, [&] {
            description->has_stretch = has_stretch<T>;
            description->has_bend = has_bend<T>;
            *instance = new T(*spec, *description);
        });
    };
    all.destroy = [](void *instance) { delete static_cast<T *>(instance); };
    if constexpr (has_stretch<T>) {
        all.stretch = [](const void *instance, const double *strains, WireloomRodResponse *out, WireloomText *message) {
            return guarded(message, [&] { static_cast<const T *>(instance)->stretch(strains, *out); });
        };
    }
    if constexpr (has_bend<T>) {
        all.bend = [](const void *instance, const double *strains, WireloomRodResponse *out, WireloomText *message) {
            return guarded(message, [&] { static_cast<const T *>(instance)->bend(strains, *out); });
        };
    }
    if constexpr (has_commit) {
        all.commit = [](const void *instance, const double *strains, WireloomRodCommit *committed,
                        WireloomText *message) {
            return guarded(message, [&] { static_cast<const T *>(instance)->commit(strains, *committed); });
        };
    }
    return all;
}

#undef WIRELOOM_CALLABLE
#undef WIRELOOM_NOT_FINAL

/// A number that is required, for the table of parameters.
inline WireloomParameter number(const char *name, const char *doc, int32_t quantity, double above, double at_most) {
    WireloomParameter one{};
    one.name = name;
    one.doc = doc;
    one.form = WIRELOOM_FORM_NUMBER;
    one.quantity = quantity;
    one.presence = WIRELOOM_PRESENCE_REQUIRED;
    one.minimum = above;
    one.minimum_excluded = 1;
    one.maximum = at_most;
    return one;
}

/// A kind of constraints, joint models or rods, with its parameters.
template <class Functions, uint32_t N>
WireloomKind kind(const char *name, const char *doc, const WireloomParameter (&parameters)[N],
                  const Functions &functions) {
    WireloomKind one{};
    one.name = name;
    one.doc = doc;
    one.parameter_count = N;
    one.parameter_stride = sizeof parameters[0];
    one.parameters = parameters;
    if constexpr (requires { functions.stations_min; }) {
        one.family = WIRELOOM_FAMILY_CONSTRAINT;
        one.constraint = &functions;
    } else if constexpr (std::is_same_v<Functions, WireloomRodKind>) {
        one.family = WIRELOOM_FAMILY_ROD;
        one.rod = &functions;
    } else {
        one.family = WIRELOOM_FAMILY_JOINT;
        one.joint = &functions;
    }
    return one;
}

} // namespace wireloom

/// Exports a plugin with the kinds of an array of WireloomKind.
#define WIRELOOM_PLUGIN(NAME, VERSION, DOC, KINDS)                                                                    \
    static const WireloomKinds *wireloom_kinds(WireloomText *) {                                                      \
        static const WireloomKinds all = {sizeof(WireloomKinds), sizeof KINDS / sizeof KINDS[0], sizeof KINDS[0], 0,  \
                                          KINDS};                                                                     \
        return &all;                                                                                                  \
    }                                                                                                                 \
    extern "C" WIRELOOM_EXPORT const WireloomEntry wireloom_plugin = {                                                \
        WIRELOOM_MAGIC, sizeof(WireloomEntry), WIRELOOM_ABI_MAJOR, WIRELOOM_ABI_MINOR, 0, NAME, VERSION, DOC,         \
        wireloom_kinds, nullptr}

#endif
