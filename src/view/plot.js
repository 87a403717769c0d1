// The error of the prediction over time.

/** Draws `values` [m], null where infinite, one a frame, and a mark at `frame`. */
function plot(canvas, values, frame) {
  const pen = canvas.getContext("2d"), { width, height } = canvas;
  const [left, right, top, bottom] = [58, width - 12, 34, height - 34];
  const most = Math.max(1e-9, ...values.filter(v => v !== null)), last = Math.max(1, values.length - 1);
  const x = t => left + ((right - left) * t) / last, y = v => bottom - ((bottom - top) * v) / most;
  pen.clearRect(0, 0, width, height);
  pen.font = "22px system-ui, sans-serif";
  pen.strokeStyle = "#d9dde1";
  pen.fillStyle = "#667079";
  for (const share of [0, 0.5, 1]) {
    pen.beginPath();
    pen.moveTo(left, y(share * most));
    pen.lineTo(right, y(share * most));
    pen.stroke();
    pen.textAlign = "right";
    pen.fillText(brief(1e3 * share * most), left - 8, y(share * most) + 7);
  }
  pen.textAlign = "left";
  const now = values[frame];
  pen.fillText(`RMSE [mm]: ${now === null ? "not finite" : (1e3 * now).toFixed(2)}`, left, 20);
  pen.fillText("0 s", left, height - 8);
  pen.textAlign = "right";
  pen.fillText(`${(last * page.interval).toFixed(2)} s`, right, height - 8);
  pen.strokeStyle = "#9aa3ab";
  pen.beginPath();
  pen.moveTo(x(frame), top);
  pen.lineTo(x(frame), bottom);
  pen.stroke();
  pen.strokeStyle = "#2a66c8";
  pen.lineWidth = 3;
  pen.beginPath();
  values.forEach((v, t) => { if (v !== null) values[t - 1] == null ? pen.moveTo(x(t), y(v)) : pen.lineTo(x(t), y(v)); });
  pen.stroke();
  pen.lineWidth = 1;
  if (now === null) return;
  pen.fillStyle = "#2a66c8";
  pen.beginPath();
  pen.arc(x(frame), y(now), 6, 0, 2 * Math.PI);
  pen.fill();
}
