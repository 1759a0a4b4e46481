// Live view of a wireloom session for notebooks (anywidget). Drag a square: a plug, clip or handle moves in the plane of
// the view, and the harness follows. Drag elsewhere: the view turns. Wheel: nearer and further.
// Messages: to Python { move, position }; from Python { step } with positions as one buffer, or { refused }.

const RADIUS = 9 // of what takes hold of a square, pixels
const COLOURS = ["#3b6fb6", "#c2703d", "#4f9152", "#8a63a8", "#b0515c", "#5c7f8a", "#917f35", "#57606a"]

function turned(view, [x, y, z]) {
  const [c, s] = [Math.cos(view.turn), Math.sin(view.turn)]
  const [ct, st] = [Math.cos(view.tilt), Math.sin(view.tilt)]
  const [right, depth] = [c * x + s * y, -s * x + c * y]
  return [right, ct * z - st * depth, ct * depth + st * z]
}

function render({ model, el }) {
  const canvas = document.createElement("canvas")
  canvas.style.cssText = "width: 100%; height: 420px; touch-action: none; cursor: grab; display: block"
  canvas.tabIndex = 0
  canvas.setAttribute("aria-label", "harness; drag a square to move a plug")
  const line = document.createElement("div")
  line.style.cssText = "font: 13px sans-serif; min-height: 1.4em; padding: 2px 4px"
  line.setAttribute("role", "status")
  el.append(canvas, line)

  const view = { turn: -0.6, tilt: 0.5, scale: 1, centre: [0, 0, 0] }
  let shape = model.get("shape")
  let lines = [] // of each branch, its nodes
  let held = null // what is dragged: a name, or the view
  let waiting = false // a move is being computed
  let wanted = null // the last place that was asked for meanwhile

  const take = (next, positions) => {
    shape = next
    const all = new Float64Array(positions.buffer, positions.byteOffset, positions.byteLength / 8)
    let from = 0
    lines = shape.branches.map(({ nodes }) => {
      const own = Array.from({ length: nodes }, (_, k) => Array.from(all.subarray(3 * (from + k), 3 * (from + k + 1))))
      from += nodes
      return own
    })
  }
  const fit = () => {
    const points = lines.flat()
    const middle = (k) => (Math.min(...points.map((p) => p[k])) + Math.max(...points.map((p) => p[k]))) / 2
    view.centre = [0, 1, 2].map(middle)
    const reach = Math.max(1e-6, ...points.map((p) => Math.hypot(...p.map((x, k) => x - view.centre[k]))))
    view.scale = (0.42 * Math.min(canvas.clientWidth || 600, canvas.clientHeight || 420)) / reach
  }
  const screen = (point) => {
    const [x, y, depth] = turned(view, point.map((p, k) => p - view.centre[k]))
    return [canvas.clientWidth / 2 + view.scale * x, canvas.clientHeight / 2 - view.scale * y, depth]
  }
  const draw = () => {
    const ratio = window.devicePixelRatio || 1
    canvas.width = Math.round(canvas.clientWidth * ratio)
    canvas.height = Math.round(canvas.clientHeight * ratio)
    const page = canvas.getContext("2d")
    page.scale(ratio, ratio)
    page.lineCap = page.lineJoin = "round"
    const deep = lines.map((own, k) => [k, own.reduce((sum, p) => sum + screen(p)[2], 0) / own.length])
    for (const [k] of deep.sort((a, b) => b[1] - a[1])) {
      page.beginPath()
      for (const point of lines[k]) page.lineTo(...screen(point).slice(0, 2))
      page.lineWidth = Math.max(1.5, view.scale * shape.branches[k].diameter)
      page.strokeStyle = COLOURS[k % COLOURS.length]
      page.stroke()
    }
    page.font = "12px sans-serif"
    for (const { name, position } of shape.constraints) {
      const [x, y] = screen(position)
      page.fillStyle = held === name ? "#d03030" : "#202428"
      page.fillRect(x - 5, y - 5, 10, 10)
      page.fillText(name, x + 9, y - 7)
    }
    // For tests, which see no pixels.
    canvas.dataset.moves = String(shape.moves)
    canvas.dataset.places = JSON.stringify(shape.constraints.map(({ name, position }) => [name, ...screen(position)]))
  }
  const say = (text, bad) => {
    line.textContent = text
    line.style.color = bad ? "#c02020" : ""
  }
  const words = () => {
    const own = shape.constraints.find(({ name }) => name === held) ?? shape.constraints.find(({ name }) => name === shape.last)
    const force = own ? `  ${own.name}: ${own.force.toFixed(2)} N` : ""
    say(`${shape.status}${force}`, shape.status !== "converged")
  }
  const ask = (name, position) => {
    wanted = { move: name, position }
    if (waiting) return
    waiting = true
    model.send(wanted)
    wanted = null
  }

  const heard = (message, buffers) => {
    if (message.step) take(message.step, buffers[0])
    waiting = false
    draw()
    if (message.refused) say(message.refused, true)
    else words()
    if (wanted) ask(wanted.move, wanted.position)
  }
  const down = (event) => {
    const [x, y] = [event.offsetX, event.offsetY]
    const near = shape.constraints.filter(({ position }) => {
      const [px, py] = screen(position)
      return Math.hypot(px - x, py - y) < RADIUS
    })
    held = near.length ? near[near.length - 1].name : canvas
    canvas.setPointerCapture(event.pointerId)
  }
  const move = (event) => {
    if (held === null) return
    const { movementX: dx, movementY: dy } = event
    if (held === canvas) {
      view.turn += 0.008 * dx
      view.tilt = Math.max(-1.5, Math.min(1.5, view.tilt + 0.008 * dy))
      return draw()
    }
    // The held point stays at its depth.
    const own = shape.constraints.find(({ name }) => name === held)
    if (!own) return
    const depth = turned(view, own.position.map((p, k) => p - view.centre[k]))[2]
    const right = (event.offsetX - canvas.clientWidth / 2) / view.scale
    const up = (canvas.clientHeight / 2 - event.offsetY) / view.scale
    const [c, s, ct, st] = [Math.cos(view.turn), Math.sin(view.turn), Math.cos(view.tilt), Math.sin(view.tilt)]
    const back = ct * depth - st * up
    const at = [c * right - s * back, s * right + c * back, ct * up + st * depth]
    ask(held, at.map((p, k) => p + view.centre[k]))
  }
  const up = () => {
    held = null
    draw()
  }
  const wheel = (event) => {
    event.preventDefault()
    view.scale *= Math.exp(-0.001 * event.deltaY)
    draw()
  }

  canvas.addEventListener("pointerdown", down)
  canvas.addEventListener("pointermove", move)
  canvas.addEventListener("pointerup", up)
  canvas.addEventListener("pointercancel", up)
  canvas.addEventListener("wheel", wheel, { passive: false })
  model.on("msg:custom", heard)
  const size = new ResizeObserver(() => draw())
  take(shape, model.get("positions"))
  size.observe(canvas)
  requestAnimationFrame(() => {
    fit()
    draw()
    words()
  })
  return () => {
    size.disconnect()
    model.off("msg:custom", heard)
  }
}

export default { render }
