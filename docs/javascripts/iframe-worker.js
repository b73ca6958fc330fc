// Search in pages that are opened from a file: browsers start no worker there, so the worker's
// script runs in a frame of the page. mkdocs-material looks for a file of this name.
if (location.protocol === "file:") {
  window.Worker = class extends EventTarget {
    constructor(url) {
      super()
      const frame = document.createElement("iframe")
      frame.hidden = true
      document.body.append(frame) // about:blank: of this page's origin
      this.scope = frame.contentWindow
      this.scope.postMessage = (data) => this.#deliver(data)
      this.scope.importScripts = (...urls) =>
        urls.reduce((before, each) => before.then(() => this.#load(each)), Promise.resolve())
      this.ready = this.#load(url)
    }

    postMessage(data) {
      this.ready.then(() => this.scope.dispatchEvent(new MessageEvent("message", { data })))
    }

    #deliver(data) {
      const event = new MessageEvent("message", { data })
      this.dispatchEvent(event)
      this.onmessage?.(event)
    }

    #load(url) {
      return new Promise((loaded, failed) => {
        const script = this.scope.document.createElement("script")
        script.src = url
        script.onload = loaded
        script.onerror = () => failed(new Error(`cannot load ${url}`))
        this.scope.document.body.append(script)
      })
    }
  }
}
