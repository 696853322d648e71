#include "azimeshMotionSolver.H"

#include "IFstream.H"
#include "OSspecific.H"
#include "Time.H"
#include "addToRunTimeSelectionTable.H"
#include "labelIOList.H"
#include "polyMesh.H"

namespace Foam
{
    defineTypeNameAndDebug(azimeshMotionSolver, 0);
    addToRunTimeSelectionTable(motionSolver, azimeshMotionSolver, dictionary);
}


Foam::azimeshMotionSolver::azimeshMotionSolver
(
    const polyMesh& mesh,
    const IOdictionary& dict
)
:
    motionSolver(mesh, dict, typeName),
    sequence_(coeffDict().get<fileName>("sequence")),
    period_(coeffDict().getOrDefault<scalar>("period", 0)),
    cubic_(true)
{
    const word kind(coeffDict().getOrDefault<word>("interpolation", "cubic"));
    if (kind != "cubic" && kind != "linear")
    {
        FatalIOErrorInFunction(coeffDict())
            << "interpolation is " << kind << "; it may be linear or cubic"
            << exit(FatalIOError);
    }
    cubic_ = kind == "cubic";

    sequence_.expand();
    if (!sequence_.isAbsolute())
    {
        sequence_ = mesh.time().globalPath()/sequence_;
    }
    sequence_.clean();

    findTimes();
    readAddressing();

    Info<< "azimesh: points of " << times_.size() << " times, "
        << times_.first().name() << " to " << times_.last().name()
        << ", in " << sequence_ << nl;
}


void Foam::azimeshMotionSolver::findTimes()
{
    DynamicList<instant> found;
    for (const instant& time : Time::findTimes(sequence_))
    {
        if (isFile(sequence_/time.name()/mesh().meshDir()/"points"))
        {
            // "constant" counts as time 0, until a folder 0 has points
            if (found.size() && found.last().value() >= time.value())
            {
                found.remove();
            }
            found.append(time);
        }
    }
    times_.transfer(found);

    if (times_.size() < 2)
    {
        FatalIOErrorInFunction(coeffDict())
            << "sequence " << sequence_ << " has " << times_.size()
            << " times with " << mesh().meshDir()/"points"
            << "; a motion needs two or more" << exit(FatalIOError);
    }

    const scalar length = times_.last().value() - times_.first().value();
    if (period_ != 0 && period_ < (1 - 1e-6)*length)
    {
        FatalIOErrorInFunction(coeffDict())
            << "period is " << period_ << ", but the sequence takes "
            << length << exit(FatalIOError);
    }

    // The last time of a closed sequence is the first one again
    if (period_ != 0 && period_ < (1 + 1e-6)*length)
    {
        times_.setSize(times_.size() - 1);
    }
}


void Foam::azimeshMotionSolver::readAddressing()
{
    if (!mesh().time().processorCase())
    {
        return;
    }

    addressing_ = labelIOList
    (
        IOobject
        (
            "pointProcAddressing",
            mesh().facesInstance(),
            polyMesh::meshSubDir,
            mesh(),
            IOobject::MUST_READ,
            IOobject::NO_WRITE,
            false
        )
    );
}


Foam::scalar Foam::azimeshMotionSolver::timeInSequence() const
{
    const Time& runTime = mesh().time();
    const scalar first = times_.first().value();
    const scalar last = times_.last().value();
    const scalar slack = 1e-6*runTime.deltaTValue();
    scalar t = runTime.timeOutputValue();

    if (period_ > 0)
    {
        t -= period_*floor((t - first + slack)/period_);
    }
    else if (t < first - slack || t > last + slack)
    {
        FatalErrorInFunction
            << "time " << t << " is outside of the sequence " << sequence_
            << ", which has " << first << " to " << last
            << "; a motion that repeats has a period" << exit(FatalError);
    }
    return t;
}


Foam::label Foam::azimeshMotionSolver::before(const scalar t) const
{
    const label n = period_ > 0 ? times_.size() : times_.size() - 1;
    label place = 0;
    while (place + 1 < n && times_[place + 1].value() <= t)
    {
        ++place;
    }
    return place;
}


Foam::label Foam::azimeshMotionSolver::neighbour
(
    const label place,
    const label step
) const
{
    const label n = times_.size();
    const label next = place + step;
    if (period_ > 0)
    {
        return (next + n) % n;
    }
    return next < n ? next : -1;
}


Foam::scalar Foam::azimeshMotionSolver::gap
(
    const label place,
    const label step
) const
{
    const label next = neighbour(place, step);
    const scalar away =
        step*(times_[next].value() - times_[place].value());
    return away > 0 ? away : away + period_;
}


Foam::pointField Foam::azimeshMotionSolver::read(const label place) const
{
    const fileName file
    (
        sequence_/times_[place].name()/mesh().meshDir()/"points"
    );
    IFstream is(file);
    IOobject io("points", mesh().time());
    if (!is.good() || !io.readHeader(is))
    {
        FatalIOErrorInFunction(is)
            << "cannot read the points" << exit(FatalIOError);
    }

    pointField whole(is);
    const label n = mesh().nPoints();
    const label needed = addressing_.size() ? max(addressing_) + 1 : n;
    if (whole.size() < needed || (addressing_.empty() && whole.size() != n))
    {
        FatalIOErrorInFunction(is)
            << "has " << whole.size() << " points; the mesh has "
            << needed << exit(FatalIOError);
    }
    return addressing_.empty() ? whole : pointField(whole, addressing_);
}


const Foam::pointField&
Foam::azimeshMotionSolver::points(const label place) const
{
    if (!loaded_.found(place))
    {
        loaded_.insert(place, read(place));
    }
    return loaded_[place];
}


Foam::pointField Foam::azimeshMotionSolver::velocity(const label place) const
{
    const label next = neighbour(place, 1);
    const label last = neighbour(place, -1);
    if (next < 0)
    {
        return (points(place) - points(last))/gap(place, -1);
    }
    if (last < 0)
    {
        return (points(next) - points(place))/gap(place, 1);
    }

    const scalar after = gap(place, 1);
    const scalar before = gap(place, -1);
    return
        (points(next) - points(place))*(before/after/(before + after))
      + (points(place) - points(last))*(after/before/(before + after));
}


Foam::tmp<Foam::pointField> Foam::azimeshMotionSolver::curPoints() const
{
    const scalar t = timeInSequence();
    const label a = before(t);
    const label b = neighbour(a, 1);
    const scalar width = gap(a, 1);
    const scalar into = t - times_[a].value();
    const scalar s = min(max(into/width, scalar(0)), scalar(1));

    // Those of other times are not needed any more
    const label last = cubic_ ? neighbour(b, 1) : b;
    const label first = cubic_ ? neighbour(a, -1) : a;
    for (const label place : loaded_.toc())
    {
        if (place != a && place != b && place != first && place != last)
        {
            loaded_.erase(place);
        }
    }

    // At a time of the sequence: its points, bit for bit
    if (s <= 1e-9)
    {
        return tmp<pointField>(new pointField(points(a)));
    }
    if (s >= 1 - 1e-9)
    {
        return tmp<pointField>(new pointField(points(b)));
    }

    // Unmoved points keep their bits: what is added to them is zero
    const pointField& from = points(a);
    const pointField way(points(b) - from);
    if (!cubic_)
    {
        return tmp<pointField>(new pointField(from + s*way));
    }

    return tmp<pointField>
    (
        new pointField
        (
            from + (s*s*(3 - 2*s))*way
          + (s*sqr(1 - s)*width)*velocity(a)
          - (sqr(s)*(1 - s)*width)*velocity(b)
        )
    );
}


void Foam::azimeshMotionSolver::updateMesh(const mapPolyMesh&)
{
    FatalErrorInFunction
        << "the points of a sequence do not fit a mesh whose topology changes"
        << exit(FatalError);
}
