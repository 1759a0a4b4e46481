// Classes of plugins with a function that the header could not call: each CASE is one of them, 0 is right.

#include "wireloom_plugin.hpp"

struct Constraint {
    Constraint(const WireloomConstraintSpec &, WireloomDescription &) {}
#if CASE == 1
private:
#endif
    void evaluate(const WireloomSituation &, WireloomEvaluation &) const {}
#if CASE == 2
    void target(const WireloomPose &, double, WireloomPose &) {}
#else
    void target(const WireloomPose &, double, WireloomPose &) const {}
#endif
#if CASE == 3
    void commit(const WireloomSituation &, float *) const {}
#else
    void commit(const WireloomSituation &, double *) const {}
#endif
#if CASE == 4
protected:
#endif
    void report(const WireloomSituation &, double *) const {}
};

struct Joint {
    Joint(const WireloomJointSpec &, WireloomJointDescription &) {}
#if CASE == 5
    void evaluate(const double *, WireloomJointEvaluation &) {}
#else
    void evaluate(const double *, WireloomJointEvaluation &) const {}
#endif
#if CASE == 6
private:
#endif
    void commit(const double *, double *) const {}
};

struct Base {
#if CASE == 7
private:
#endif
    void bend(const double *, WireloomRodResponse &) const {}
};

#if CASE == 8
struct Rod final : Base {
#else
struct Rod : Base {
#endif
    Rod(const WireloomRodSpec &, WireloomRodDescription &) {}
#if CASE == 9
    void stretch(const double *, WireloomRodResponse &) {}
#else
    void stretch(const double *, WireloomRodResponse &) const {}
#endif
#if CASE == 11
    void commit(const double *, double *) const {}
#else
    void commit(const double *, WireloomRodCommit &) const {}
#endif
};

struct Lawless {
    Lawless(const WireloomRodSpec &, WireloomRodDescription &) {}
};

const WireloomConstraintKind constraint = wireloom::constraint_functions<Constraint>();
const WireloomJointKind joint = wireloom::joint_functions<Joint>();
#if CASE == 10
const WireloomRodKind rod = wireloom::rod_functions<Lawless>();
#else
const WireloomRodKind rod = wireloom::rod_functions<Rod>();
#endif
const WireloomParameter none[] = {wireloom::number("stiffness", "not used", WIRELOOM_QUANTITY_FORCE_PER_LENGTH, 0.0, 1.0)};
const WireloomKind kinds[] = {wireloom::kind("one", "a constraint", none, constraint),
                              wireloom::kind("two", "a joint", none, joint), wireloom::kind("three", "a rod", none, rod)};

WIRELOOM_PLUGIN("callable", "0.0.1", "classes of all kinds", kinds);
